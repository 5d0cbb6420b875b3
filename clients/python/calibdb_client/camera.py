"""An open camera that knows its label: OpenCV's capture, and its name in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .board import opencv
from .devices import Device, find
from .errors import CameraError

MAX_READS = 30
"""Frames that are waited for: many cameras deliver their first picture late."""


class Camera:
    """A `cv2.VideoCapture`, which cannot be derived from, with the label and platform that Chromium uses.

    Attributes of the capture are also the camera's. Its zoom is 0: browsers report zoom only to pages that
    may change it.
    """

    zoom = 0.0

    def __init__(self, capture: Any, label: str, platform: str, img_size: tuple[int, int]) -> None:
        self.capture = capture
        self.label = label
        self.platform = platform
        self.img_size = img_size

    def __repr__(self) -> str:
        return f"Camera({self.label!r}, {self.img_size[0]}x{self.img_size[1]})"

    def __getattr__(self, name: str) -> Any:
        if name == "capture":  # while it is being made
            raise AttributeError(name)
        return getattr(self.capture, name)

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, *_: object) -> None:
        self.capture.release()


def open_camera(camera: int | str, size: tuple[int, int] | None = None) -> Camera:
    """Open a camera of this machine by its index, path, or a part of its label.

    `size`: width and height that the pictures must have, px; by default the camera's own.

    Raises CameraError if it is not there, busy, or has no such size; MissingPackageError without OpenCV.
    """
    cv2 = opencv("a camera is opened")
    chosen = find(camera)
    capture = cv2.VideoCapture(chosen.index, chosen.backend)
    try:
        if not capture.isOpened():
            raise CameraError(_access_problem(chosen))
        if size is not None:
            w, h = size
            # Most cameras give their large sizes, at a usable rate, only as JPEG.
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG"))
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, w)
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, h)
        delivered = _first_size(capture)
        if delivered is None:
            raise CameraError(f"{chosen.label} delivers no picture: unplug it, plug it in, and try again")
        if size is not None and delivered != tuple(size):
            raise CameraError(
                f"{chosen.label} delivers {delivered[0]}x{delivered[1]} and not {size[0]}x{size[1]}: "
                "ask for a size that it has"
            )
    except BaseException:
        capture.release()
        raise
    return Camera(capture, chosen.label, chosen.platform, delivered)


def _first_size(capture: Any) -> tuple[int, int] | None:
    for _ in range(MAX_READS):
        there, frame = capture.read()
        if there:
            h, w = frame.shape[:2]
            return int(w), int(h)
    return None


def _access_problem(device: Device) -> str:
    path = Path(device.path)
    if device.path.startswith("/dev/"):
        try:
            path.open("rb").close()
        except PermissionError:
            return f"{device.label} may not be opened: add yourself to the group video, and log in again"
        except OSError:
            return f"{device.label} was unplugged: plug it in, and try again"
    return f"{device.label} cannot be opened: close other programs that use it, and try again"
