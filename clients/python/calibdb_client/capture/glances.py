"""Glances at a board: a few still frames of different tilts, for the check of a calibration."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from calibsolver.arrays import Array

from ..checks import CHECK_VIEWS
from ..detection import Detector
from ..errors import CaptureError
from ..recording import RecordedView, Recording
from .feedback import Scene
from .guide import Status
from .live import HOLD_S
from .operation import CaptureInterruptedError, CaptureOptions, Operation, prepare
from .outline import difference, outline_of
from .stillness import Stillness

if TYPE_CHECKING:
    from typing import Unpack

MIN_DIFFERENCE = 0.06
"""Difference of two views' tilts, as a share of the board's size, from which both tell something."""
MAX_GLANCES_S = 180.0


def recording_to_check(camera: Any, **options: Unpack[CaptureOptions]) -> Recording:
    """Return a recording as it is, or take one of three views of a camera, hands-free, in different tilts.

    Raises CameraError, CaptureError if it takes longer than three minutes, CaptureInterruptedError.
    """
    return camera if isinstance(camera, Recording) else _take_glances(prepare(camera, **options))


def _take_glances(operation: Operation) -> Recording:
    recording, frames, feedback = operation.recording, operation.frames, operation.feedback
    detector, width = Detector(recording.board), recording.key.img_size[0]
    still, taken = Stillness(), list[Array]()
    began: float | None = None
    try:
        while len(taken) < CHECK_VIEWS:
            frame = frames.next()
            if frame is None:
                break
            began = frame.time if began is None else began
            if frame.time - began > MAX_GLANCES_S:
                raise CaptureError(
                    f"{len(taken)} views in three minutes: hold the board still, tilted differently"
                )
            corners = detector.find(frame.picture)
            still = still.observe(corners, frame.time, width, repeated=frame.repeated)
            outline = None if corners is None else outline_of(recording.board, corners.ids, corners.points)
            another, hold = False, 0.0
            if outline is None:
                words = "show the board to the camera"
            elif all(difference(outline, each) > MIN_DIFFERENCE for each in taken):
                words, another, hold = "hold the board still", True, min(1.0, still.held / HOLD_S)
            else:
                words = "tilt the board another way"
            status = Status(len(taken), len(taken) / CHECK_VIEWS)
            points = None if corners is None else corners.points
            if feedback.show(Scene(frame.picture, points, None, words, hold, status)) == "stop":
                raise KeyboardInterrupt
            if another and corners is not None and outline is not None and still.held >= HOLD_S:
                view = RecordedView.of(f"view {len(taken) + 1}", corners)
                recording = replace(recording, views=(*recording.views, view))
                taken.append(outline)
                still = Stillness()
                feedback.taken(Status(len(taken), len(taken) / CHECK_VIEWS))
    except KeyboardInterrupt:
        raise CaptureInterruptedError(recording) from None
    finally:
        operation.close()
    return recording
