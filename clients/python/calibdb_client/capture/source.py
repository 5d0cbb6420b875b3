"""Sources of a capture and their frames: a camera here, a stream, a video, or an object with `read()`."""

import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from ..board import opencv
from ..camera import open_camera
from ..errors import CameraError, CaptureError, UsageError
from ..key import HasLabel

VIDEO_SUFFIXES = frozenset(
    ".avi .m4v .mjpeg .mjpg .mkv .mov .mp4 .mpeg .mpg .ts .webm .wmv .y4m".split()  # noqa: SIM905
)
TIMEOUT_MS = 10_000
MAX_LOST_READS = 90
"""Reads without a picture after which a camera counts as unplugged."""
LOST_PAUSE_S = 0.03
_FRAME_COUNT, _POSITION_MSEC = 7, 0  # of cv2.VideoCapture


@dataclass(frozen=True, eq=False)
class NamedSource:
    """Open source: its name in sentences, without a password, and label and platform of a local camera.

    `owned`: it was opened here and must be closed.
    """

    source: Any
    name: str
    label: str | None = None
    platform: str | None = None
    owned: bool = False

    def close(self) -> None:
        """Release what was opened here."""
        if self.owned:
            self.source.release()


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture (h, w) or (h, w, 3), 8 bits, its time in seconds; `repeated` is the previous one again."""

    picture: Any
    time: float
    repeated: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        h, w = self.picture.shape[:2]
        return int(w), int(h)


class Frames:
    """Frames of a source, all of one size; `clock` gives seconds, a file has its own time."""

    def __init__(self, source: NamedSource, clock: Callable[[], float] = time.monotonic) -> None:
        self.source = source
        self._clock = clock
        self._last: Frame | None = None
        self._waiting: Frame | None = None
        self.is_file = self._property(_FRAME_COUNT) > 0
        """True if it ends and has its own time."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures, px. Raises CaptureError or CameraError if there is none."""
        if self._last is None:
            self._waiting = self._read()
        if self._last is None:
            raise CaptureError(f"{self.source.name} contains no image: pass another file")
        return self._last.size

    def next(self) -> Frame | None:
        """Return the next frame; None at the end of a file.

        Raises CameraError if the camera delivers no more pictures, or pictures of another size.
        """
        if self._waiting is not None:
            frame, self._waiting = self._waiting, None
            return frame
        return self._read()

    def _read(self) -> Frame | None:
        name, last = self.source.name, self._last
        for _ in range(MAX_LOST_READS):
            there, picture = self._read_source()
            if there and picture is not None:
                break
            if self.is_file:
                return None
            time.sleep(LOST_PAUSE_S)
        else:
            lost = "delivers no picture" if last is None else "delivers no more pictures"
            raise CameraError(f"{name} {lost}: see that it is plugged in, and that no other program uses it")
        position = self._property(_POSITION_MSEC) / 1000 if self.is_file else self._clock()
        same = last is not None and np.array_equal(picture, last.picture)
        frame = Frame(picture, position, same)
        if last is not None and frame.size != last.size:
            (w, h), (u, v) = last.size, frame.size
            change = f"changed its pictures from {w}x{h} to {u}x{v}"
            raise CameraError(f"{name} {change}: set it to {w}x{h} for all of the capture")
        self._last = frame
        return frame

    def _read_source(self) -> tuple[bool, Any]:
        try:
            there, picture = self.source.source.read()
        except (OSError, RuntimeError, ValueError) as error:
            raise CameraError(f"{self.source.name} cannot be read ({error}): plug it in again") from None
        except opencv().error:
            return False, None
        return bool(there), picture

    def _property(self, number: int) -> float:
        """Return a property of a `cv2.VideoCapture`; 0 of what has none."""
        get = getattr(self.source.source, "get", None)
        try:
            return float(get(number)) if callable(get) else 0.0
        except (TypeError, ValueError, KeyError):
            return 0.0


def is_stream(text: object) -> bool:
    """True if this is the address of a stream, such as ``rtsp://camera.example/1``."""
    return isinstance(text, str) and bool(re.match(r"(rtsps?|rtmp|https?|udp|tcp)://", text))


def is_video(text: object) -> bool:
    """True if this names an existing video file."""
    if not isinstance(text, (str, Path)) or is_stream(text):
        return False
    path = Path(text)
    return path.suffix.lower() in VIDEO_SUFFIXES and path.is_file()


def open_source(camera: Any, size: tuple[int, int] | None = None) -> NamedSource:
    """Open a camera by index, path or name, a stream by its address, a video file; or take an open source.

    Raises CameraError if it cannot be opened, UsageError if it is not a source.
    """
    if is_stream(camera):
        return _open_stream(str(camera))
    if is_video(camera):
        capture = opencv().VideoCapture(str(camera))
        if not capture.isOpened():
            raise UsageError(f"{camera} cannot be read as a video: convert it, or give pictures of it")
        return NamedSource(capture, str(camera), owned=True)
    if isinstance(camera, (int, str)):
        opened = open_camera(camera, size)
        return NamedSource(opened, opened.label, opened.label, opened.platform, owned=True)
    if not callable(getattr(camera, "read", None)):
        raise UsageError(f"{camera!r} is not a camera: pass an index, an address, or an object with read()")
    if isinstance(camera, HasLabel):
        return NamedSource(camera, camera.label, camera.label, camera.platform)
    return NamedSource(camera, "the camera")


def _open_stream(address: str) -> NamedSource:
    cv2 = opencv()
    try:
        name = f"the stream of {urlsplit(address).hostname or 'the stream'}"
    except ValueError:
        raise UsageError("not an address of a stream, such as rtsp://camera.example/1") from None
    limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, TIMEOUT_MS, cv2.CAP_PROP_READ_TIMEOUT_MSEC, TIMEOUT_MS]
    capture = cv2.VideoCapture(address, cv2.CAP_FFMPEG, limits)
    if not capture.isOpened():
        raise CameraError(f"{name} cannot be opened: check the address, the password and the network")
    return NamedSource(capture, name, owned=True)
