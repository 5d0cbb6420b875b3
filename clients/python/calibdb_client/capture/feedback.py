"""Feedback of a capture: what the person sees, hears and may press, as text or in a window."""

import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TextIO

import numpy as np

from calibsolver.arrays import Array

from ..board import opencv
from .guide import Status, Target

Command = Literal["", "skip", "stop"]
MIN_INSTRUCTION_S = 1.2
"""Time between two instructions: people read one before the next."""
SETTLED_S = 0.4
"""Time for which an instruction must be the right one before it is given."""
TITLE = "calibdb"
MAX_SHOWN_SIDE_PX = 1280
"""Longer side of what is shown; larger pictures are shrunk."""
_GREEN, _MAGENTA, _WHITE, _BLACK = (80, 220, 80), (220, 80, 220), (255, 255, 255), (0, 0, 0)
_ESCAPE = 27


@dataclass(frozen=True, eq=False)
class Scene:
    """State of a capture at one frame.

    `picture` is (h, w) or (h, w, 3). Corners seen are (n, 2) px, None without a board; there is no target
    while the service is asked. `hold`: 0 to 1, part of the time for which the board must be held still.
    """

    picture: Any
    points: Array | None
    target: Target | None
    instruction: str
    hold: float
    status: Status


class Feedback(Protocol):
    """Interface of the feedback to the user during a capture."""

    def show(self, scene: Scene) -> Command:
        """Show one frame's state, and return what the person wants."""

    def taken(self, status: Status) -> None:
        """Tell that a view was taken."""

    def note(self, text: str) -> None:
        """Tell a sentence."""

    def close(self) -> None:
        """End."""


class Terminal:
    """Text hints, line by line; a bell for each view. On a terminal, one line shows the progress."""

    def __init__(self, stream: TextIO | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream or sys.stderr
        self._clock = clock
        self._live = self._stream.isatty()
        self._said, self._said_at = "", float("-inf")
        self._wanted, self._wanted_at = "", float("-inf")
        self._bar: Any = None

    def show(self, scene: Scene) -> Command:
        """Say the instruction, if it is another one."""
        now = self._clock()
        if scene.instruction != self._wanted:
            self._wanted, self._wanted_at = scene.instruction, now
        settled = now - self._wanted_at >= SETTLED_S and now - self._said_at >= MIN_INSTRUCTION_S
        if self._wanted and self._wanted != self._said and settled:
            self._said, self._said_at = self._wanted, now
            if not self._live:
                self.note(self._said)
        if self._live:
            self._draw(scene)
        return ""

    def taken(self, status: Status) -> None:
        """Ring, and say how far the capture is."""
        self._said = ""
        self.note(f"view taken: {_progress_words(status)}")
        if self._live:
            self._stream.write("\a")
            self._stream.flush()

    def note(self, text: str) -> None:
        """Say a sentence."""
        if self._bar is not None:
            self._bar.console.print(text, markup=False, highlight=False)
        else:
            print(text, file=self._stream, flush=True)

    def close(self) -> None:
        """Leave the line of the progress."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _draw(self, scene: Scene) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskID, TextColumn

        if self._bar is None:
            columns = (BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
            console = Console(file=self._stream)
            # Refreshed by hand: no thread of its own.
            self._bar = Progress(*columns, console=console, auto_refresh=False, transient=True)
            self._bar.start()
            self._bar.add_task("", total=1.0)
        hold = "" if scene.hold <= 0 else f" {100 * scene.hold:.0f} %"
        words = f"{_progress_words(scene.status)} · {self._said or scene.instruction}{hold}"
        self._bar.update(TaskID(0), completed=scene.status.progress, description=words)
        self._bar.refresh()


class Window(Terminal):
    """A window of OpenCV's highgui, and text. Keys: Esc or q ends, n or space asks for another pose."""

    def show(self, scene: Scene) -> Command:
        """Draw the frame, and read the keyboard."""
        cv2 = opencv()
        cv2.imshow(TITLE, draw(scene))
        key = cv2.waitKey(1) & 0xFF
        closed = cv2.getWindowProperty(TITLE, cv2.WND_PROP_VISIBLE) < 1
        if closed or key in (_ESCAPE, ord("q")):
            return "stop"
        super().show(scene)
        return "skip" if key in (ord("n"), ord(" ")) else ""

    def close(self) -> None:
        """Close the window."""
        super().close()
        cv2 = opencv()
        try:
            cv2.destroyWindow(TITLE)
            cv2.waitKey(1)
        except cv2.error:
            return  # it was closed by hand


def has_window() -> bool:
    """True if OpenCV can open a window here: its build has highgui, and there is a display."""
    cv2 = opencv()
    framework = getattr(cv2, "currentUIFramework", None)
    try:
        built = bool(framework()) if framework else True
    except cv2.error:
        return False
    display = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return built and (display or sys.platform in ("win32", "darwin"))


def draw(scene: Scene) -> Any:
    """Return the picture (h, w, 3) to show: target in magenta, corners in green, words below."""
    cv2 = opencv()
    picture = scene.picture
    canvas = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture.copy()
    factor = min(1.0, MAX_SHOWN_SIDE_PX / max(canvas.shape[:2]))
    if factor < 1:
        canvas = cv2.resize(canvas, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    if scene.target is not None and len(scene.target.outline):
        outline = np.round(factor * np.clip(scene.target.outline, -1e4, 1e4)).astype(np.int32)
        cv2.polylines(canvas, [outline], True, _MAGENTA, 3, cv2.LINE_AA)
    for point in [] if scene.points is None else factor * scene.points:
        cv2.circle(canvas, tuple(np.round(point).astype(int).tolist()), 3, _GREEN, -1, cv2.LINE_AA)
    h, w = canvas.shape[:2]
    cv2.rectangle(canvas, (0, h - 6), (round(w * scene.status.progress), h), _GREEN, -1)
    cv2.rectangle(canvas, (0, h - 14), (round(w * scene.hold), h - 8), _WHITE, -1)
    for n, text in enumerate((scene.instruction, _progress_words(scene.status))):
        place = (12, 32 + 30 * n)
        for colour, width in ((_BLACK, 5), (_WHITE, 2)):
            cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.8, colour, width, cv2.LINE_AA)
    return canvas


def _progress_words(status: Status) -> str:
    views = f"{status.views} view{'' if status.views == 1 else 's'}"
    error = "" if status.error is None else f", {status.error:.2f} px"
    return f"{views}, {100 * status.progress:.0f} %{error}"
