"""Guides of a capture, which choose targets and judge views: the service, or calibsolver on this machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from calibsolver.arrays import Array

from ..calibration import Maker
from ..flows import Flow
from ..key import live_model
from ..offline import calibrate_recording
from ..recording import RecordedView, Recording
from ..session import CaptureResult, refusal, result_of, start, submit
from ..wire import Request

if TYPE_CHECKING:
    from calibsolver.guidance import TargetPose

TARGET_ERROR_WIDTHS = 0.3 / 1280
"""Predicted error / image width at which a capture ends, as the service has it."""


@dataclass(frozen=True, eq=False)
class Target:
    """Pose in which the board is wanted: corners (n, 2) px with their ids, and the board's edge (m, 2) px.

    `index` is that of the view that answers it.
    """

    index: int
    ids: tuple[int, ...]
    corners: Array
    outline: Array

    @classmethod
    def of(cls, values: Mapping[str, Any], index: int) -> Target:
        """Return the target of plain values, as the service and `TargetPose.to_dict` give them."""
        return cls(
            index,
            tuple(int(each) for each in values["ids"]),
            np.array(values["corners"], dtype=np.float64).reshape(-1, 2),
            np.array(values["outline"], dtype=np.float64).reshape(-1, 2),
        )


@dataclass(frozen=True)
class Status:
    """Course of a capture: views that are in, progress 0 to 1, and predicted error over the image, px.

    Without a fit there is no error.
    """

    views: int = 0
    progress: float = 0.0
    error: float | None = None
    done: bool = False


@dataclass(frozen=True)
class Judgement:
    """Judgement of a view, with the reason and the next movement if it is refused, and the course with it."""

    accepted: bool
    status: Status
    reason: str = ""
    hint: str = ""


class ServiceGuide:
    """A live session of the service. `make` turns its record into a calibration."""

    def __init__(self, recording: Recording, model: str, make: Maker, consent: Mapping[str, str]) -> None:
        self._recording, self._model, self._make, self._consent = recording, model, make, consent
        self._session = ""
        self._state: Mapping[str, Any] = {}

    def start(self) -> Flow[Status]:
        """Open a session."""
        self._session, self._state = yield from start(self._recording, self._model, "live", self._consent)
        return self._status()

    def target(self, skip: bool = False) -> Flow[Target]:
        """Ask for the pose."""
        query = {"skip": "1"} if skip else {}
        reply = yield Request("GET", "v1/session/pose", query=query, credential=self._session)
        return Target.of(reply.json, int(reply.json["index"]))

    def judge(self, target: Target, view: RecordedView) -> Flow[Judgement]:
        """Send the corners."""
        body = {"index": target.index, **view.record()}
        reply = yield Request("POST", "v1/session/views", body, credential=self._session)
        self._state = answer = reply.json
        hint = answer.get("hint") or {}
        words = "" if answer.get("accepted") else refusal(answer.get("reason"))
        return Judgement(bool(answer.get("accepted")), self._status(), words, str(hint.get("code", "")))

    def finish(self, recording: Recording) -> Flow[CaptureResult]:
        """Return the session's calibration; of one that has not converged, its views' as recorded ones."""
        state, status = self._state, self._status()
        if not (status.done and isinstance(state.get("calibration"), dict)):
            return (yield from submit(recording, self._model, self._make, consent=self._consent))
        return result_of(state, self._make, status.views, (), state.get("suggested_model"))

    def _status(self) -> Status:
        state = self._state
        uncertainty = state.get("uncertainty") or {}
        return Status(
            views=sum(not each.get("set_aside") for each in state.get("views", [])),
            progress=float(state.get("progress") or 0.0),
            error=uncertainty.get("rms"),
            done=state.get("status") == "converged",
        )


class OfflineGuide:
    """calibsolver on this machine; `model` is that of the calibration."""

    def __init__(self, recording: Recording, model: str) -> None:
        from calibsolver.capture import Capture, History

        self._model, self._board = model, recording.board
        size = recording.key.img_size
        target_error = TARGET_ERROR_WIDTHS * size[0]
        self._capture = Capture(self._board, size, live_model(model), target_error=target_error)
        self._estimate = self._capture.estimate([])
        self._history = History()
        self._views: list[Any] = []
        self._accepted: list[RecordedView] = []
        self._quarantined: list[Any] = []
        self._skipped: tuple[TargetPose, ...] = ()
        self._unreached: tuple[TargetPose, ...] = ()
        self._pose: TargetPose | None = None

    def start(self) -> Flow[Status]:
        """Begin."""
        yield from ()
        return self._status()

    def target(self, skip: bool = False) -> Flow[Target]:
        """Choose the pose."""
        yield from ()
        if self._pose is not None and skip:
            self._skipped = (*self._skipped, self._pose)
            self._pose = None
        if self._pose is None:
            self._pose = self._capture.next_target(
                self._views, self._estimate, self._skipped, self._unreached
            )
        return Target.of(self._pose.to_dict(), len(self._views))

    def judge(self, target: Target, view: RecordedView) -> Flow[Judgement]:
        """Judge by the rules of the service."""
        yield from ()
        del target
        observation = self._board.view(view.ids, view.points)
        decision = self._capture.judge(
            self._views, self._pose, observation, self._estimate.excluded, self._quarantined, self._history
        )
        self._history = decision.after(self._history)
        if decision.seed_rejected:
            self._capture = self._capture.without_seed()
        if not decision.accepted or decision.estimate is None:
            self._quarantined += [observation] if decision.quarantine else []
            hint = decision.hint.code if decision.hint else ""
            return Judgement(False, self._status(), refusal(decision.reason), hint)
        self._views.append(observation)
        self._accepted.append(view)
        self._estimate = decision.estimate
        self._unreached, self._skipped = (*self._unreached, *self._skipped), ()
        self._quarantined, self._pose = [], None
        return Judgement(True, self._status())

    def finish(self, recording: Recording) -> Flow[CaptureResult]:
        """Fit the views that are not excluded."""
        yield from ()
        included = tuple(view for i, view in enumerate(self._accepted) if i not in self._estimate.excluded)
        views = included if self._is_done else recording.views
        return calibrate_recording(replace(recording, views=views), self._model)

    @property
    def _count(self) -> int:
        return len(self._views) - len(self._estimate.excluded)

    @property
    def _is_done(self) -> bool:
        return self._estimate.converged or self._history.is_exhausted(self._count)

    def _status(self) -> Status:
        estimate = self._estimate
        return Status(
            views=self._count,
            progress=estimate.progress,
            error=estimate.uncertainty.rms if estimate.uncertainty else None,
            done=self._is_done,
        )


Guide = ServiceGuide | OfflineGuide
"""Chooser of targets and judge of views."""
