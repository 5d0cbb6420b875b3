"""State of a rig."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from calibdb.rules.quality_gates import TARGET_ERROR_PER_WIDTH
from calibdb.rules.rig_rules import MIN_AGREEING_VIEWS
from calibdb.schema import RigDocument, RigEstimateDocument, RigState, SessionDocument, ViewDocument
from calibdb.schema.membership import MAX_RIG_CAMERAS
from calibdb.schema.rig import (
    LatestMoment,
    MomentSetAside,
    RigAdvice,
    RigCamera,
    RigMoment,
    SetAsideReason,
)
from calibdb.schema.rig_documents import RigFit, SkipsDocument

INITIAL_ERROR_PER_WIDTH = 0.03  # predicted error, px / image width, from which progress is measured
LINKED_SHARE = 0.3  # progress when all cameras are linked
MAX_UNFINISHED_PROGRESS = 0.95
Moments = list[tuple[str, dict[int, ViewDocument]]]  # ids, and views by position
_REASONS: Mapping[str, SetAsideReason] = {
    "outlier": "outlier",
    "disagrees": "contradicts",
    "degenerate": "degenerate",
}
_SET_ASIDE_DETAILS: Mapping[SetAsideReason, str] = {
    "outlier": "Its corners cannot be explained.",
    "mirrored": "The picture is mirrored.",
    "degenerate": "Its corners lie on a line.",
    "contradicts": "It contradicts the rig: the board or the camera moved during the moment.",
}


@dataclass(frozen=True)
class Rig:
    """Running rig: its document, and the sessions by position."""

    document: RigDocument
    sessions: tuple[SessionDocument | None, ...]

    @property
    def present(self) -> Iterator[tuple[int, SessionDocument]]:
        """Positions and sessions of joined cameras."""
        return ((i, session) for i, session in enumerate(self.sessions) if session is not None)

    @property
    def target_error(self) -> float:
        """Error at which the rig has converged, px."""
        return TARGET_ERROR_PER_WIDTH * max([s.img_size[0] for _, s in self.present], default=1280)

    def moments(self) -> Moments:
        """Moments that are not undone."""
        by_moment: Moments = [(moment.id, {}) for moment in self.document.moments if not moment.undone]
        for name, by_position in by_moment:
            for position, session in self.present:
                by_position.update((position, view) for view in session.views if view.moment == name)
        return by_moment

    def basis(self, solver: str) -> str:
        """Digest of everything that the fit follows from."""
        cameras = [[position, session.session, session.first_version] for position, session in self.present]
        views = [
            [name, sorted((p, v.index) for p, v in by_position.items())]
            for name, by_position in self._used_moments()
        ]
        text = json.dumps([solver, len(self.sessions), cameras, views])
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def digest(self, basis: str) -> str:
        """Digest of fit and target: of the views, and of targets not wanted."""
        skips = self._skips(basis)
        if skips is None:
            return basis
        return hashlib.sha256(skips.model_dump_json().encode()).hexdigest()[:32]

    def solver_record(self, basis: str) -> dict[str, Any]:
        """Inputs of the solver."""
        skips = self._skips(basis)
        return {
            "board": self.document.board.model_dump(),
            "cameras": [_camera(session) for session in self.sessions],
            "moments": [
                {"id": name, "views": {p: {"ids": v.ids, "points": v.points} for p, v in by_position.items()}}
                for name, by_position in self._used_moments()
            ],
            "skipped": skips.poses if skips else (),
            "missed": skips.missed if skips else 0,
        }

    def _skips(self, basis: str) -> SkipsDocument | None:
        skips = self.document.skips
        return skips if skips is not None and skips.basis == basis else None

    def _used_moments(self) -> Moments:
        """Moments with the views that no session has set aside."""
        used = [
            (name, {p: v for p, v in by_position.items() if v.set_aside is None})
            for name, by_position in self.moments()
        ]
        return [(name, by_position) for name, by_position in used if by_position]

    def count_agreeing(self, fit: RigFit | None) -> list[int]:
        """Numbers of each camera's views that agree with the others."""
        out = {(one.moment, one.position) for one in fit.set_aside} if fit else set()
        counts = [0] * len(self.sessions)
        for name, by_position in self._used_moments():
            for position in by_position:
                counts[position] += (name, position) not in out
        return counts


def _camera(session: SessionDocument | None) -> dict[str, Any] | None:
    if session is None:
        return None
    near = session.estimate.fit or session.prior
    return {
        "img_size": session.img_size,
        "distortion_model": session.distortion_model,
        "start": near.model_dump() if near else None,
    }


def state(rig: Rig, estimate: RigEstimateDocument) -> RigState:
    """State of a running rig in the API."""
    fit, moments = estimate.fit, rig.moments()
    return RigState(
        rig_id=rig.document.rig,
        status="capturing",
        board=rig.document.board,
        square_size=rig.document.square_size,
        unit=unit(rig.document),
        cameras=tuple(_cameras(rig, moments)),
        moment=_latest(rig, moments),
        moments=tuple(_moment(name, by_position, fit) for name, by_position in moments),
        uncertainty=fit and fit.uncertainty,
        target_error=rig.target_error,
        progress=_progress(rig, estimate),
        unlinked=estimate.unlinked,
        rms=fit and fit.rms,
        target=estimate.target,
        advice=tuple(_advice(rig, estimate)),
        result=None,
    )


def unit(document: RigDocument) -> Any:
    """Unit of a rig's lengths."""
    return "squares" if document.square_size is None else "metres"


def _is_converged(rig: Rig, fit: RigFit | None) -> bool:
    enough = min(rig.count_agreeing(fit)) >= MIN_AGREEING_VIEWS
    return fit is not None and enough and fit.uncertainty.rms <= rig.target_error


def _progress(rig: Rig, estimate: RigEstimateDocument) -> float:
    fit = estimate.fit
    if _is_converged(rig, fit):
        return 1.0
    if fit is None:
        linked = len(rig.sessions) - 1 - len(estimate.unlinked)
        return LINKED_SHARE * max(linked, 0) / (len(rig.sessions) - 1)
    start = INITIAL_ERROR_PER_WIDTH / TARGET_ERROR_PER_WIDTH * rig.target_error
    near = math.log(start / max(fit.uncertainty.rms, 1e-9)) / math.log(start / rig.target_error)
    least = min(near, min(rig.count_agreeing(fit)) / MIN_AGREEING_VIEWS, MAX_UNFINISHED_PROGRESS)
    return max(LINKED_SHARE, least)


def _cameras(rig: Rig, moments: Moments) -> Iterator[RigCamera]:
    for position, session in enumerate(rig.sessions):
        yield RigCamera(
            position=position,
            camera=session and session.camera,
            img_size=session and session.img_size,
            distortion_model=session and session.distortion_model,
            status="waiting" if session is None else "capturing",
            views=sum(position in by_position for _, by_position in moments),
        )


def _latest(rig: Rig, moments: Moments) -> LatestMoment | None:
    """Moment that was opened last, None if it is undone."""
    if not moments or moments[-1][0] != rig.document.moments[-1].id:
        return None
    name, by_position = moments[-1]
    return LatestMoment(id=name, positions=tuple(sorted(by_position)))


def _moment(name: str, by_position: Mapping[int, ViewDocument], fit: RigFit | None) -> RigMoment:
    reasons = {p: _REASONS[v.set_aside.reason] for p, v in by_position.items() if v.set_aside is not None}
    if fit is not None:
        reasons |= {one.position: one.reason for one in fit.set_aside if one.moment == name}
    aside = [
        MomentSetAside(position=p, reason=r, detail=_SET_ASIDE_DETAILS[r]) for p, r in sorted(reasons.items())
    ]
    return RigMoment(id=name, positions=tuple(sorted(by_position)), set_aside=tuple(aside))


def _advice(rig: Rig, estimate: RigEstimateDocument) -> Iterator[RigAdvice]:
    fit = estimate.fit
    waiting = tuple(i for i, session in enumerate(rig.sessions) if session is None)
    if waiting:
        yield RigAdvice(code="waiting", text=f"{named(waiting)} not joined yet.", positions=waiting)
    lost = tuple(i for i in estimate.unlinked if i not in waiting)
    if lost and rig.moments():
        text = f"{named(lost)} not seen the board together with the others: hold it where both see it."
        yield RigAdvice(code="unlinked", text=text, positions=lost)
    if estimate.problem is not None:
        yield RigAdvice(code="no_fit", text=f"The cameras cannot be fitted yet: {estimate.problem}.")
    if fit is None:
        return
    wrong = tuple(sorted({one.position for one in fit.set_aside if one.reason == "contradicts"}))
    if wrong:
        text = f"{named(wrong)} views that contradict the others; they were left out: something moved."
        yield RigAdvice(code="contradicts", text=text, positions=wrong)
    others = tuple(sorted({one.position for one in fit.set_aside if one.reason != "contradicts"}))
    if others:
        text = "Views were left out because their corners cannot be explained."
        yield RigAdvice(code="set_aside", text=text, positions=others)
    turned = tuple(sorted({one.position for one in fit.turned}))
    if turned:
        text = "In some views the board was numbered from another side; this was corrected."
        yield RigAdvice(code="turned", text=text, positions=turned)
    few = tuple(i for i, n in enumerate(rig.count_agreeing(fit)) if n < MIN_AGREEING_VIEWS)
    if few:
        text = f"{named(few)} fewer than {MIN_AGREEING_VIEWS} views that agree."
        yield RigAdvice(code="too_few_views", text=text, positions=few)
    if _is_converged(rig, fit):
        yield RigAdvice(code="converged", text="The rig is as sure as it is to be: it can be finished.")


def named(positions: Sequence[int]) -> str:
    """Name cameras, with the verb: `Camera 1 has`, `Cameras 1 and 2 have`."""
    if len(positions) == 1:
        return f"Camera {positions[0]} has"
    *most, last = map(str, positions[:MAX_RIG_CAMERAS])
    return f"Cameras {', '.join(most)} and {last} have"
