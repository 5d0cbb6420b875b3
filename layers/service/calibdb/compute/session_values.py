"""Sessions as the solver's values, and its estimates as documents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import JsonValue

from calibdb.compute.values import board_of, camera_of, views_of
from calibdb.schema import EstimateDocument, SessionDocument
from calibsolver import Camera, View
from calibsolver.capture import Capture, Estimate, Exclusion, History
from calibsolver.fitting.coverage import record_covered, uncertainty_members
from calibsolver.guidance import TargetPose


@dataclass(frozen=True)
class Session:
    """A session as the solver's values."""

    rules: Capture
    views: list[View]
    excluded: dict[int, Exclusion]

    @classmethod
    def of(cls, document: SessionDocument) -> Session:
        """Convert a document."""
        rules = Capture(
            board_of(document.board),
            document.img_size,
            model=document.distortion_model,
            guidance=document.guidance,
            target_error=document.target_error,
            seed=None if document.prior is None else camera_of(document.prior),
            recorded=document.capture == "recorded" or document.rig is not None,
        )
        excluded = {
            i: Exclusion.from_record(view.set_aside.model_dump())
            for i, view in enumerate(document.views)
            if view.set_aside is not None
        }
        return cls(rules, views_of(rules.board, document.views), excluded)

    @property
    def active(self) -> list[View]:
        """Views that are not excluded."""
        return [view for i, view in enumerate(self.views) if i not in self.excluded]

    def estimate(self) -> Estimate:
        """Estimate the camera from the views."""
        return self.rules.estimate(self.views, self.excluded)


def current_camera(document: SessionDocument, rules: Capture) -> Camera:
    """Return the camera of the session's fit, or the initial one."""
    fit = document.estimate.fit
    return rules.camera(None) if fit is None else camera_of(fit)


def target_poses(records: Sequence[Mapping[str, JsonValue]]) -> tuple[TargetPose, ...]:
    """Read stored targets."""
    return tuple(map(TargetPose.from_dict, records))


def history_of(document: SessionDocument) -> History:
    """Return the course of a session so far."""
    stated = tuple(view.stated for view in document.views)
    return History(stated, tuple(bool(view.on_target) for view in document.views), document.duplicates)


def estimate_document(estimate: Estimate, now: int) -> EstimateDocument:
    """Return an estimate as it is stored."""
    fit, uncertainty, coverage = estimate.calibration, estimate.uncertainty, estimate.coverage
    stated = None
    if uncertainty and coverage:
        stated = {"rms": uncertainty.rms, "max": uncertainty.max, **uncertainty_members(coverage)}
    record: dict[str, Any] = {
        "time": now,
        "fit": record_covered(fit, coverage) if fit and coverage else None,
        "uncertainty": stated,
        "progress": estimate.progress,
        "converged": estimate.converged,
        "end": estimate.end,
        "advice": [{"code": advice.code, "text": advice.text} for advice in estimate.advice],
        "suggested_model": estimate.suggested_model,
    }
    return EstimateDocument.model_validate(record)


def view_statuses(estimate: Estimate) -> list[tuple[float | None, dict[str, str] | None]]:
    """List each view's error, px, and why it is excluded if it is."""
    reasons = [estimate.excluded.get(i) for i in range(len(estimate.view_errors))]
    stored = [{"reason": r.reason, "detail": r.detail} if r else None for r in reasons]
    return list(zip(estimate.view_errors, stored, strict=True))
