"""Sources of a capture: a camera here, the address of a stream, a video file, or an object with `read()`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from ..board import opencv
from ..camera import open_camera
from ..errors import CameraError, UsageError
from ..key import HasLabel

VIDEO_SUFFIXES = frozenset(
    (
        ".avi",
        ".m4v",
        ".mjpeg",
        ".mjpg",
        ".mkv",
        ".mov",
        ".mp4",
        ".mpeg",
        ".mpg",
        ".ts",
        ".webm",
        ".wmv",
        ".y4m",
    )
)
OPEN_TIMEOUT_MS, READ_TIMEOUT_MS = 10_000, 10_000


@dataclass(frozen=True, eq=False)
class NamedSource:
    """An open source, and what is known of its camera.

    Attributes
    ----------
    name
        Its name in sentences, without a password.
    label, platform
        Of a local camera; None: the caller must name it.
    owned
        True if it was opened here and must be closed.
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
    if callable(getattr(camera, "read", None)):
        if isinstance(camera, HasLabel):
            return NamedSource(camera, camera.label, camera.label, camera.platform)
        return NamedSource(camera, "the camera")
    raise UsageError(f"{camera!r} is not a camera: pass an index, an address, or an object with read()")


def _open_stream(address: str) -> NamedSource:
    cv2 = opencv()
    try:
        host = urlsplit(address).hostname or "the stream"
    except ValueError:
        raise UsageError("not an address of a stream, such as rtsp://camera.example/1") from None
    limits = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
        OPEN_TIMEOUT_MS,
        cv2.CAP_PROP_READ_TIMEOUT_MSEC,
        READ_TIMEOUT_MS,
    ]
    capture = cv2.VideoCapture(address, cv2.CAP_FFMPEG, limits)
    if not capture.isOpened():
        raise CameraError(
            f"the stream of {host} cannot be opened: check the address, the password and the network"
        )
    return NamedSource(capture, f"the stream of {host}", owned=True)
