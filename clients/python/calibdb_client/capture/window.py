"""Feedback in a window of OpenCV's highgui: the picture, the target's outline, the instruction."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

from ..board import opencv
from .feedback import Command, Feedback, Scene, progress_words
from .guide import Status

TITLE = "calibdb"
MAX_SHOWN_SIDE_PX = 1280
"""Longer side of what is shown; larger pictures are shrunk."""
_GREEN, _MAGENTA, _WHITE, _BLACK = (80, 220, 80), (220, 80, 220), (255, 255, 255), (0, 0, 0)
_ESCAPE = 27


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


class Window:
    """A window, and the terminal below it. Keys: Esc or q ends, n or space asks for another pose."""

    def __init__(self, terminal: Feedback) -> None:
        self._terminal = terminal
        self._cv2 = opencv()

    def show(self, scene: Scene) -> Command:
        """Draw the frame, and read the keyboard."""
        cv2 = self._cv2
        cv2.imshow(TITLE, draw(scene))
        key = cv2.waitKey(1) & 0xFF
        closed = cv2.getWindowProperty(TITLE, cv2.WND_PROP_VISIBLE) < 1
        if closed or key in (_ESCAPE, ord("q")):
            return "stop"
        self._terminal.show(scene)
        return "skip" if key in (ord("n"), ord(" ")) else ""

    def taken(self, status: Status) -> None:
        """Ring in the terminal."""
        self._terminal.taken(status)

    def note(self, text: str) -> None:
        """Say a sentence in the terminal."""
        self._terminal.note(text)

    def close(self) -> None:
        """Close the window."""
        self._terminal.close()
        try:
            self._cv2.destroyWindow(TITLE)
            self._cv2.waitKey(1)
        except self._cv2.error:
            return  # it was closed by hand


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
    for n, text in enumerate((scene.instruction, progress_words(scene.status))):
        place = (12, 32 + 30 * n)
        for colour, width in ((_BLACK, 5), (_WHITE, 2)):
            cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.8, colour, width, cv2.LINE_AA)
    return canvas
