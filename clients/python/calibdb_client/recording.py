"""Recordings: captured corners in a file, written before anything is sent, so that nothing is lost."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .board import Board
from .errors import UsageError
from .files import read_object, write_whole
from .key import CameraKey

if TYPE_CHECKING:
    from calibsolver import View

    from .detection import Corners

Progress = Callable[[int, int], None]
"""Called with the number done, and the number of all."""
FORMAT = "calibdb-recording-1"
_MEMBER = "recording"


@dataclass(frozen=True)
class RecordedView:
    """Corners of one picture: the name of its file, numbers (n) and places (n, 2), px."""

    source: str
    ids: tuple[int, ...]
    points: tuple[tuple[float, float], ...]

    @classmethod
    def of(cls, source: str, corners: Corners) -> RecordedView:
        """Return the view of corners that were found in a picture."""
        return cls(source, corners.ids, tuple((float(u), float(v)) for u, v in corners.points.tolist()))

    def record(self) -> dict[str, Any]:
        """Return the corners as the members of a request."""
        return {"ids": list(self.ids), "points": [list(point) for point in self.points]}


@dataclass(frozen=True)
class Recording:
    """Views of one camera and one board, in the order in which they were taken.

    `live`: a guided capture took them, which can continue with them.
    """

    key: CameraKey
    board: Board
    views: tuple[RecordedView, ...]
    live: bool = False

    def observations(self) -> list[View]:
        """Return the views as calibsolver takes them. Raises ValueError for a corner that is given twice."""
        return self.board.views(view.record() for view in self.views)

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Read a file that `save` wrote. Raises UsageError for any other file."""
        try:
            return cls.of(read_object(Path(path)) or {})
        except UsageError as error:
            raise UsageError(f"{path}: {error}") from None

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Recording:
        """Return the recording in the content of a file. Raises UsageError if there is none."""
        try:
            record = content[_MEMBER]
            if record["format"] != FORMAT:
                raise UsageError("of a version that this one does not know: upgrade calibdb-client")
            w, h = record["img_size"]
            columns, rows = record["board"]["squares"]
            board = Board(**{**record["board"], "squares": (int(columns), int(rows))})
            live = record.get("live") is True
            key = CameraKey(str(record["camera"]), str(record["platform"]), (w, h), float(record["zoom"]))
            return cls(key, board, tuple(_view(each, board) for each in record["views"]), live)
        except UsageError:
            raise
        except (ValueError, KeyError, TypeError):
            raise UsageError("the file does not contain a recording of calibdb") from None

    def save(self, path: str | Path) -> None:
        """Write the file, as a whole or not at all. Raises UsageError if it cannot be written."""
        write_whole(Path(path), self.content())

    def content(self, calibration: Mapping[str, Any] | None = None) -> bytes:
        """Return the file's content; with a calibration it is also that calibration's file."""
        member = {
            **self.key.record(),
            "format": FORMAT,
            "board": self.board.record(),
            **({"live": True} if self.live else {}),
            "views": [{"source": view.source, **view.record()} for view in self.views],
        }
        return json.dumps({**(calibration or {}), _MEMBER: member}, ensure_ascii=False).encode() + b"\n"


def ignore(recording: Recording) -> None:
    """Keep nothing of a recording."""
    del recording


def _view(record: Mapping[str, Any], board: Board) -> RecordedView:
    ids = tuple(int(each) for each in record["ids"])
    points = tuple((float(u), float(v)) for u, v in record["points"])
    finite = all(math.isfinite(each) for point in points for each in point)
    if len(ids) != len(points) or not finite or not all(0 <= each < board.corner_count for each in ids):
        raise ValueError("corners that are none")
    return RecordedView(str(record["source"]), ids, points)
