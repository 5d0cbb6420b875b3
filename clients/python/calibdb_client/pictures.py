"""Pictures of a board in files: which are read, and the corners that they show."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .board import Board
from .detection import Detector, recognise
from .detection.recognition import MAX_LOOKED_AT
from .errors import CaptureError, UsageError
from .recording import RecordedView

T = TypeVar("T")

SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp"})
PLATFORM = "photographs"
"""Platform of pictures that no browser's camera took."""
MAX_PICTURES = 400
"""Pictures that are read; of more, as many spread evenly over their names."""
MAX_VIEWS = 100
MAX_POINTS = 20_000
MIN_VIEWS = 4
"""Views of which the service makes a calibration."""


@dataclass
class FoundViews:
    """Views found in pictures so far, and names of pictures without one.

    Attributes
    ----------
    views
        Views with their picture's size, px.
    broken
        Sentence about a video that breaks off.
    empty, unreadable
        Names of pictures without the board, and of files that are no pictures.
    """

    views: list[tuple[tuple[int, int], RecordedView]] = field(default_factory=list)
    empty: list[str] = field(default_factory=list)
    broken: str = ""
    unreadable: list[str] = field(default_factory=list)

    def of_one_size(self, least: int = MIN_VIEWS) -> tuple[tuple[int, int], tuple[RecordedView, ...]]:
        """Return the size that most views have, and those views, at most as many as the service takes.

        Raises CaptureError if there are fewer than `least`.
        """
        if not self.views:
            raise CaptureError(self._nothing())
        sizes = Counter(size for size, _ in self.views)
        size, count = sizes.most_common(1)[0]
        if count < least:
            several = f" of {size[0]}x{size[1]} px" if len(sizes) > 1 else ""
            raise CaptureError(
                f"{count} pictures{several} show the board, and {least} are needed, better 10: "
                "take more, with the board tilted in several ways"
            )
        views = _spread([view for each, view in self.views if each == size], MAX_VIEWS)
        while sum(len(view.ids) for view in views) > MAX_POINTS:
            views = _spread(views, len(views) - 1)
        return size, tuple(views)

    def other_sizes(self, size: tuple[int, int]) -> int:
        """Count the views of other sizes."""
        return sum(each != size for each, _ in self.views)

    def _nothing(self) -> str:
        if self.unreadable and not self.empty:
            return "none of the files can be read as a picture: give JPEG, PNG, TIFF or WebP files"
        return (
            "the board is in none of the pictures: describe it by --kind, --squares, --marker-ratio and "
            "--dictionary, and --legacy if OpenCV before 4.6 drew it"
        )


def picture_paths(given: Iterable[str | Path]) -> list[Path]:
    """List picture files: those given, and those in the folders given, by name.

    Raises UsageError if a path is not there, or a folder has no pictures.
    """
    paths: list[Path] = []
    for each in map(Path, given):
        if each.is_dir():
            with os.scandir(each) as entries:
                inside = [
                    Path(e.path) for e in entries if Path(e.name).suffix.lower() in SUFFIXES and e.is_file()
                ]
            if not inside:
                raise UsageError(f"{each} holds no pictures (JPEG, PNG, TIFF, WebP, BMP)")
            paths += sorted(inside)
        elif each.is_file():
            paths.append(each)
        else:
            raise UsageError(f"{each} is not there")
    if not paths:
        raise UsageError("name a folder of pictures, or pictures")
    return paths


def read(
    paths: Sequence[Path], board: Board, found: FoundViews, progress: Callable[[int, int], None] | None = None
) -> None:
    """Find the board in pictures, and add to `found` one by one: an interruption loses nothing.

    Pixels are those of the file: an orientation that the camera wrote beside them is not applied.
    """
    detector = Detector(board)
    chosen = _spread(list(paths), MAX_PICTURES)
    for n, path in enumerate(chosen):
        content = _content(path)
        picture = _decode(content) if content else None
        if picture is None:
            found.unreadable.append(path.name)
        elif (corners := detector.find(picture)) is None:
            found.empty.append(path.name)
        else:
            h, w = picture.shape[:2]
            points = tuple((float(u), float(v)) for u, v in corners.points.tolist())
            found.views.append(((w, h), RecordedView(path.name, corners.ids, points)))
        if progress:
            progress(n + 1, len(chosen))


def recognise_board(paths: Sequence[Path]) -> Board | None:
    """Return the board in pictures, of which some, spread evenly, are looked at; None if they do not tell."""
    chosen = _spread(list(paths), 2 * MAX_LOOKED_AT)
    for some in (chosen[::2], chosen[1::2]):
        pictures = (_decode(content) for path in some if (content := _content(path)))
        board = recognise(each for each in pictures if each is not None)
        if board is not None:
            return board
    return None


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def _decode(content: bytes) -> Any:
    """Return a picture (h, w) in shades of grey; None if it is none."""
    import cv2

    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        return cv2.imdecode(np.frombuffer(content, dtype=np.uint8), flags)
    except cv2.error:  # more pixels than OpenCV reads
        return None


def _spread(values: Sequence[T], count: int) -> list[T]:
    """Return at most `count` of the values, spread evenly."""
    if len(values) <= count:
        return list(values)
    return [values[n * len(values) // count] for n in range(count)]
