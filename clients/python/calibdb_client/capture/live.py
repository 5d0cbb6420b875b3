"""Live capture: frames become views, hands-free, when the board is still and where it helps.

The rules and numbers are those of the capture page. A conversation: it yields the requests of its guide.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calibsolver.arrays import Array

from ..board import DESCRIBE_IT, Board
from ..detection import Corners, Detector, recognise
from ..errors import CaptureError
from ..flows import Flow
from ..pictures import MIN_VIEWS
from ..recording import RecordedView, Recording
from ..session import CaptureResult
from .feedback import Feedback, Scene
from .guide import Guide, Status, Target
from .outline import TEXTS, advice, difference, foreshortening, outline_of, overlap
from .source import Frame, Frames
from .stillness import REFERENCE_WIDTH_PX, Stillness, motion

HOLD_S, LONG_HOLD_S = 0.7, 1.5
"""Time for which the board is still at the target; anywhere else, where the view may help all the same."""
FROZEN_HOLD_S = 3.0
"""Time of a hold that shows one picture again and again: a camera that stalls looks like a steady hand."""
MIN_HOLD_FRAMES = 3
MIN_OVERLAP, MAX_DIFFERENCE = 0.75, 0.06
"""Overlap with the target, and difference in tilt, that count as there."""
TOLERANCES, TOLERANT_AFTER_S = (0.8, 1.6), 10.0
"""Factors on what a hand may miss by, at first and after that time. Users who follow words stop as soon as
they end, and at the picture's border a hand's breadth is most of the information of a view."""
MIN_FORESHORTENING = 0.08
"""From which a pose other than the target may help."""
MIN_DISPLACEMENT_PX = 26.0
"""At 1280 px image width, from the last view that was judged. Duplicates are refused up to 25.6 px."""
IDLE_S = 30.0
"""Time without another view after which a capture ends if it has enough of them."""
STUCK_S, MAX_TARGET_S = 15.0, 45.0
"""Time without coming nearer, and in all, after which another pose is asked for."""
READ_REFUSAL_S = 2.0
"""Time to read why a view at the target was refused, before another pose is asked for."""
MIN_APPROACH = 0.05
LENIENT_AFTER_S, MAX_LENIENCE = 3.0, 4.0
"""Time in which a steady hand would be still; later, so many times its motion also counts as still."""
RECOGNITION_FRAMES = 5
MAX_RECOGNITION_FRAMES = 900


@dataclass
class _Aim:
    """Target of the moment, and how near the board came to it.

    `outline` is the board's edge (4, 2) px in it, None if it shows too little. Times are seconds;
    `refused_at` is that of a view at it.
    """

    target: Target
    outline: Array | None
    since: float
    nearest: float = float("inf")
    nearest_at: float = 0.0
    refused_at: float | None = None


class Live:
    """One live capture.

    `recording` has the camera, the board, and the views of an earlier capture to continue.

    `keep` is called with the recording after each view, before anything else happens.
    """

    def __init__(
        self,
        frames: Frames,
        recording: Recording,
        guide: Guide,
        feedback: Feedback,
        keep: Callable[[Recording], object],
    ) -> None:
        self.recording = recording
        self._frames, self._guide, self._feedback, self._keep = frames, guide, feedback, keep
        self._detector = Detector(recording.board)
        self._width = recording.key.img_size[0]
        self._status = Status()
        self._aim: _Aim | None = None
        self._still = Stillness()
        self._judged: Corners | None = None
        self._taken_at: float | None = None
        self._required: float | None = None

    def run(self) -> Flow[CaptureResult]:
        """Capture until the guide has converged, the file ends, or the person stops with views enough."""
        self._status = yield from self._guide.start()
        yield from self._replay()
        while not self._status.done:
            frame = self._frames.next()
            if frame is None or self._is_idle(frame.time):
                break
            if self._aim is None:
                yield from self._set_target(frame.time)
            corners = self._detector.find_fast(frame.picture) or self._detector.find(frame.picture)
            command = self._observe(frame, corners)
            if command == "stop":
                break
            if command == "skip" or self._is_stuck(frame.time):
                yield from self._set_target(frame.time, skip=True)
            elif corners is not None and self._is_due(corners):
                yield from self._judge(corners, frame.time)
        count = len(self.recording.views)
        if count < MIN_VIEWS:
            raise CaptureError(
                f"{count} views were taken, and {MIN_VIEWS} are needed: `calibdb resume` continues with them"
            )
        return (yield from self._guide.finish(self.recording))

    def _replay(self) -> Flow[None]:
        """Offer the views of an earlier capture; those that are refused stay in the file."""
        for view in self.recording.views:
            if self._status.done:
                return
            target = yield from self._guide.target()
            judgement = yield from self._guide.judge(target, view)
            self._status = judgement.status

    def _set_target(self, time: float, skip: bool = False) -> Flow[None]:
        target = yield from self._guide.target(skip)
        edge = outline_of(self.recording.board, target.ids, target.corners)
        self._aim = _Aim(target, edge, time, nearest_at=time)
        self._still = Stillness()

    def _current_aim(self) -> _Aim:
        assert self._aim is not None  # noqa: S101 - set before each frame
        return self._aim

    def _observe(self, frame: Frame, corners: Corners | None) -> str:
        """Update the hold and the distance from the target, and show the frame."""
        aim = self._current_aim()
        elapsed = frame.time - aim.since
        tolerance = float(np.interp(elapsed, (0.0, TOLERANT_AFTER_S), TOLERANCES))
        lenience = min(MAX_LENIENCE, max(1.0, elapsed / LENIENT_AFTER_S))
        self._still = self._still.observe(corners, frame.time, self._width, lenience, frame.repeated)
        outline = None if corners is None else outline_of(self.recording.board, corners.ids, corners.points)
        there, instruction = False, "show the board to the camera"
        if corners is not None and outline is None:
            instruction = TEXTS["show_more"]
        if outline is not None:
            covered = overlap(outline, aim.target.outline, frame.size)
            off = difference(outline, aim.outline) if aim.outline is not None else 0.0
            there = 1 - covered < (1 - MIN_OVERLAP) * tolerance and off < MAX_DIFFERENCE * tolerance
            distance = 1 - covered + off
            if distance < aim.nearest - MIN_APPROACH:
                aim.nearest, aim.nearest_at = distance, frame.time
            code = "" if there or aim.outline is None else advice(outline, aim.outline, tolerance)
            instruction = TEXTS[code or "hold_still"]
        self._required = self._required_hold(outline, there, corners)
        hold = 0.0 if self._required is None else min(1.0, self._still.held / self._required)
        points = None if corners is None else corners.points
        return self._feedback.show(Scene(frame.picture, points, aim.target, instruction, hold, self._status))

    def _required_hold(self, seen: Array | None, there: bool, corners: Corners | None) -> float | None:
        """Time for which the board must be still where it is; None: no view is taken there."""
        if seen is None or corners is None:
            return None
        nearest = MIN_DISPLACEMENT_PX * self._width / REFERENCE_WIDTH_PX
        if self._judged is not None and motion(self._judged, corners) < nearest:
            return None
        if not there and not self._frames.is_file and foreshortening(seen) < MIN_FORESHORTENING:
            return None
        usual = HOLD_S if there or self._frames.is_file else LONG_HOLD_S
        return usual if self._still.frames >= MIN_HOLD_FRAMES else FROZEN_HOLD_S

    def _is_due(self, corners: Corners) -> bool:
        """True if a view is taken now: the hold is long enough, and this frame belongs to it."""
        return (
            self._required is not None and self._still.last is corners and self._still.held >= self._required
        )

    def _is_idle(self, time: float) -> bool:
        """True if no view was taken for IDLE_S, and those taken make a calibration."""
        if self._taken_at is None:
            self._taken_at = time
        enough = self._status.views >= MIN_VIEWS and not self._frames.is_file
        return enough and time - self._taken_at > IDLE_S

    def _is_stuck(self, time: float) -> bool:
        aim = self._current_aim()
        if aim.refused_at is not None:
            return time - aim.refused_at > READ_REFUSAL_S
        if self._still.anchor is None:  # while no board is in sight, another pose would not help
            return False
        return time - aim.nearest_at > STUCK_S or time - aim.since > MAX_TARGET_S

    def _judge(self, corners: Corners, time: float) -> Flow[None]:
        aim = self._current_aim()
        view = RecordedView.of(f"view {len(self.recording.views) + 1}", corners)
        before = self.recording
        self.recording = replace(before, views=(*before.views, view))
        self._keep(self.recording)
        judgement = yield from self._guide.judge(aim.target, view)
        self._judged, self._still = corners, Stillness()
        self._status = judgement.status
        if judgement.accepted:
            self._feedback.taken(judgement.status)
            self._aim, self._taken_at = None, time
            return
        if self._frames.is_file:
            return  # the board cannot be moved: the views of a file are fitted together at its end
        self.recording = before
        self._keep(before)
        words = TEXTS.get(judgement.hint, "")
        self._feedback.note(f"not taken: {judgement.reason}{'; ' + words if words else ''}")
        aim.refused_at = time


def first_board(frames: Frames, feedback: Feedback) -> Board:
    """Return the undescribed board that the first frames show; CaptureError if none is recognised."""
    feedback.note("show the board to the camera: it will be recognised")
    observations: list[Any] = []
    for _ in range(MAX_RECOGNITION_FRAMES):
        frame = frames.next()
        if frame is not None:
            observations.append(frame.picture)
        if frame is None or len(observations) == RECOGNITION_FRAMES:
            board = recognise(observations)
            if board is not None:
                feedback.note(f"board: {board}")
                return board
            observations = []
        if frame is None:
            break
    raise CaptureError(f"no board was recognised: {DESCRIBE_IT}")
