"""Frames of a source."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..board import opencv
from ..errors import CameraError, CaptureError

MAX_LOST_READS = 90
"""Reads without a picture after which a camera counts as unplugged."""
LOST_PAUSE_S = 0.03
_FRAME_COUNT, _POSITION_MSEC = 7, 0  # of cv2.VideoCapture


class Source(Protocol):
    """Source of pictures, as `cv2.VideoCapture` is one."""

    def read(self) -> tuple[bool, Any]:
        """Return whether there is a picture, and the picture (h, w) or (h, w, 3), 8 bits."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture (h, w) or (h, w, 3), 8 bits; `time` in seconds from any start.

    `repeated`: True if it is identical to the previous one.
    """

    picture: Any
    time: float
    repeated: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        h, w = self.picture.shape[:2]
        return int(w), int(h)


class Frames:
    """Frames of a source, all of one size. `name` is the source's in errors; a file has its own clock."""

    def __init__(
        self,
        source: Source,
        name: str = "the camera",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.source = source
        self.name = name
        self._clock = clock
        self._size: tuple[int, int] | None = None
        self._last: Any = None
        self.is_file = _property(source, _FRAME_COUNT) > 0
        """True if it ends and has its own time."""
        self._waiting: Frame | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures, px. Raises CaptureError or CameraError if there is none."""
        if self._size is None:
            self._waiting = self._read()
            if self._waiting is None:
                raise CaptureError(f"{self.name} contains no image: pass another file")
        assert self._size is not None  # noqa: S101 - set with the first picture
        return self._size

    def next(self) -> Frame | None:
        """Return the next frame; None at the end of a file.

        Raises CameraError if the camera delivers no more pictures, or pictures of another size.
        """
        if self._waiting is not None:
            frame, self._waiting = self._waiting, None
            return frame
        return self._read()

    def _read(self) -> Frame | None:
        for _ in range(MAX_LOST_READS):
            there, picture = self._read_source()
            if there and picture is not None:
                break
            if self.is_file:
                return None
            time.sleep(LOST_PAUSE_S)
        else:
            lost = "delivers no picture" if self._size is None else "delivers no more pictures"
            raise CameraError(
                f"{self.name} {lost}: see that it is plugged in, and that no other program uses it"
            )
        position = _property(self.source, _POSITION_MSEC) / 1000 if self.is_file else self._clock()
        same = self._last is not None and np.array_equal(picture, self._last)
        self._last = picture
        frame = Frame(picture, position, same)
        if self._size is None:
            self._size = frame.size
        elif frame.size != self._size:
            (w, h), (u, v) = self._size, frame.size
            raise CameraError(
                f"{self.name} changed its pictures from {w}x{h} to {u}x{v}: "
                f"set it to {w}x{h} for all of the capture"
            )
        return frame

    def _read_source(self) -> tuple[bool, Any]:
        try:
            there, picture = self.source.read()
        except (OSError, RuntimeError, ValueError) as error:
            raise CameraError(f"{self.name} cannot be read ({error}): plug it in again") from None
        except opencv().error:
            return False, None
        return bool(there), picture


def _property(source: Any, number: int) -> float:
    get = getattr(source, "get", None)
    try:
        return float(get(number)) if callable(get) else 0.0
    except (TypeError, ValueError, KeyError):
        return 0.0
