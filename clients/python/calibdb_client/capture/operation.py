"""A whole live capture: source, board, guide and feedback together."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from ..board import Board
from ..devices import platform_of
from ..errors import CalibDBError, UsageError
from ..flows import Flow
from ..key import UNNAMED, CameraKey
from ..recording import Recording
from ..session import CaptureResult
from .feedback import Feedback, Terminal, Window, has_window
from .guide import Guide
from .live import Live, first_board
from .source import Frames, NamedSource, open_source

if TYPE_CHECKING:
    from typing import Unpack

Show = Literal["auto", "window", "text", "none"] | Feedback
Keep = Callable[[Recording], object]


class CaptureOptions(TypedDict, total=False):
    """Options of a live capture, of which each has a default.

    Attributes
    ----------
    label, platform, zoom
        Key of the camera; default: that of a browser on this machine.
    size
        Width and height that its pictures must have, px.
    board
        Recognised by default.
    show
        ``window``, ``text``, ``none``, ``auto`` (a window where there is one, else text), or a `Feedback`.
    resume
        Recording of an earlier capture of this camera, to continue.
    clock
        Seconds, by which the board's stillness is timed; a file has its own.
    """

    label: str | None
    platform: str | None
    zoom: float | None
    size: tuple[int, int] | None
    board: Board | None
    show: Show
    resume: Recording | None
    clock: Callable[[], float]


class CaptureInterruptedError(KeyboardInterrupt):
    """The user ended the capture; `recording` has the views so far."""

    def __init__(self, recording: Recording) -> None:
        super().__init__("interrupted")
        self.recording = recording


@dataclass(frozen=True, eq=False)
class Operation:
    """A capture that is about to begin.

    `recording` has the camera, the board, and the views of an earlier capture to continue.
    """

    frames: Frames
    feedback: Feedback
    recording: Recording

    def close(self) -> None:
        """Close the window, and the camera if it was opened here."""
        self.feedback.close()
        self.frames.source.close()

    def run(self, guide: Callable[[Recording], Guide], keep: Keep) -> Flow[CaptureResult]:
        """Capture by a guide, made from the recording, which calibrates."""
        live: Live | None = None
        try:
            live = Live(self.frames, self.recording, guide(self.recording), self.feedback, keep)
            return (yield from live.run())
        except CalibDBError as error:
            error.recording = live.recording if live else self.recording
            raise
        except KeyboardInterrupt:
            raise CaptureInterruptedError(live.recording if live else self.recording) from None
        finally:
            self.close()


def prepare(camera: Any, named: bool = True, **options: Unpack[CaptureOptions]) -> Operation:
    """Open the source, as `open_source` does, and find out what it shows.

    `named`: the camera must have a label, without which its calibration cannot be looked up.

    Raises CameraError, CaptureError, MissingPackageError or UsageError.
    """
    size, resume = options.get("size"), options.get("resume")
    if resume is not None:
        size = size or resume.key.img_size
    feedback = _feedback(options.get("show", "auto"))
    source = open_source(camera, size)
    try:
        frames = Frames(source, options.get("clock", time.monotonic))
        delivered = frames.size
        if size is not None and delivered != tuple(size):
            raise UsageError(
                f"{source.name} delivers {delivered[0]}x{delivered[1]} and not {size[0]}x{size[1]}: "
                "set it to that size"
            )
        if resume is None:
            key = _key(source, delivered, named, options)
            resume = Recording(key, options.get("board") or first_board(frames, feedback), ())
        return Operation(frames, feedback, replace(resume, live=True))
    except BaseException:
        feedback.close()
        source.close()
        raise


def _feedback(show: Show) -> Feedback:
    if not isinstance(show, str):
        return show
    if show == "none":
        return Terminal(io.StringIO())
    if show not in ("auto", "window", "text"):
        raise UsageError(f"a capture is shown by auto, window, text or none, not {show!r}")
    if show == "text" or not has_window():
        if show == "window":
            raise UsageError("there is no window here: say text, or install opencv-python and set DISPLAY")
        return Terminal()
    return Window()


def _key(source: NamedSource, size: tuple[int, int], named: bool, options: CaptureOptions) -> CameraKey:
    label = options.get("label") or source.label
    if label is None and named:
        raise UsageError(f"which camera is {source.name}? Say its label, as a browser gives it")
    zoom = options.get("zoom")
    if zoom is None:
        zoom = float(getattr(source.source, "zoom", 0.0) or 0.0)
    platform = options.get("platform") or source.platform or platform_of()
    return CameraKey(label or UNNAMED, platform, size, zoom)
