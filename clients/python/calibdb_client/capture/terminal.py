"""Feedback by text and the terminal's bell: for programs without a window, over SSH too."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, TextIO

from .feedback import Command, Scene, progress_words
from .guide import Status

MIN_INSTRUCTION_S = 1.2
"""Time between two instructions: people read one before the next."""
SETTLED_S = 0.4
"""Time for which an instruction must be the right one before it is given."""


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
                self._line(self._said)
        if self._live:
            self._draw(scene)
        return ""

    def taken(self, status: Status) -> None:
        """Ring, and say how far the capture is."""
        self._said = ""
        self._line(f"view taken: {progress_words(status)}")
        if self._live:
            self._stream.write("\a")
            self._stream.flush()

    def note(self, text: str) -> None:
        """Say a sentence."""
        self._line(text)

    def close(self) -> None:
        """Leave the line of the progress."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _line(self, text: str) -> None:
        if self._bar is not None:
            self._bar.console.print(text, markup=False, highlight=False)
        else:
            print(text, file=self._stream, flush=True)

    def _draw(self, scene: Scene) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskID, TextColumn

        if self._bar is None:
            columns = (BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
            # Refreshed by hand: no thread of its own.
            self._bar = Progress(
                *columns, console=Console(file=self._stream), auto_refresh=False, transient=True
            )
            self._bar.start()
            self._bar.add_task("", total=1.0)
        hold = "" if scene.hold <= 0 else f" {100 * scene.hold:.0f} %"
        words = f"{progress_words(scene.status)} · {self._said or scene.instruction}{hold}"
        self._bar.update(TaskID(0), completed=scene.status.progress, description=words)
        self._bar.refresh()
