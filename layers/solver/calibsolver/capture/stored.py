"""Stored sessions: the solver's values of their plain ones, and back."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..errors import CalibrationError
from ..fitting.coverage import Coverage, record_covered, uncertainty_members
from ..fitting.fit import fit
from ..guidance.target import TargetPose
from ..view import View
from .decision import Estimate, Exclusion, exclusions
from .rules import Capture


def parse(record: Mapping[str, Any]) -> tuple[Capture, list[View], dict[int, Exclusion]]:
    """Read the rules of a session, its views, and those of them that are excluded, from its plain values."""
    rules = Capture.from_record(record)
    return rules, rules.board.views(record["views"]), exclusions(record["views"])


def parse_targets(records: Sequence[Mapping[str, Any]]) -> tuple[TargetPose, ...]:
    """Read stored targets."""
    return tuple(TargetPose.from_dict(record) for record in records)


def estimate_record(estimate: Estimate) -> dict[str, Any]:
    """Return an estimate as plain values."""
    fit, uncertainty, coverage = estimate.calibration, estimate.uncertainty, estimate.coverage
    stated = None
    if uncertainty and coverage:
        stated = {"rms": uncertainty.rms, "max": uncertainty.max, **uncertainty_members(coverage)}
    return {
        "fit": record_covered(fit, coverage) if fit and coverage else None,
        "uncertainty": stated,
        "progress": estimate.progress,
        "converged": estimate.converged,
        "end": estimate.end,
        "advice": [{"code": advice.code, "text": advice.text} for advice in estimate.advice],
        "suggested_model": estimate.suggested_model,
    }


def view_statuses(estimate: Estimate) -> list[tuple[float | None, dict[str, str] | None]]:
    """List each view's error, px, and why it is excluded if it is."""
    reasons = [estimate.excluded.get(i) for i in range(len(estimate.view_errors))]
    stored = [{"reason": r.reason, "detail": r.detail} if r else None for r in reasons]
    return list(zip(estimate.view_errors, stored, strict=True))


@dataclass(frozen=True)
class Outcome:
    """Outcome of a capture that ends: the fit's record, with the board's shape and rivals, and a report."""

    fit: dict[str, Any]
    report: dict[str, Any]


def end(estimate: Estimate, views: Sequence[View], indices: Sequence[int]) -> Outcome | None:
    """Describe a capture that ends with this estimate of its views; None where there is no fit.

    `indices`: names of the views that are not excluded, in their order.
    """
    from ..quality import report  # here alone: who shows a target has no use for it
    from ..quality.rivals import with_rivals

    if estimate.calibration is None:
        return None
    used = [one for i, one in enumerate(views) if i not in estimate.excluded]
    found, camera = estimate.calibration, estimate.calibration.camera
    try:
        shaped = fit(used, camera.img_size, camera.model, start=camera, board_shape=True)
    except CalibrationError:
        shaped = found
    judged = with_rivals(found if shaped.board_shape is None else shaped, used)
    record = record_covered(judged, Coverage.of(judged, used))
    return Outcome(record, report.describe(judged, used, indices))


def finish(record: Mapping[str, Any]) -> dict[str, Any]:
    """End a session with the views that agree, however accurate they are.

    Returns its `estimate` (`estimate_record`), the `statuses` of its views (`view_statuses`) and a `report`.
    Raises CalibrationError where no camera explains the views.
    """
    rules, views, excluded = parse(record)
    found = rules.estimate(views, excluded).with_cause(views)
    found = replace(found, progress=1.0, end="asked")
    indices = [view["index"] for i, view in enumerate(record["views"]) if i not in found.excluded]
    outcome = end(found, views, indices)
    if outcome is None:
        raise CalibrationError("no_fit", "no camera explains these views")
    known = estimate_record(found)
    return {
        "estimate": {**known, "fit": outcome.fit},
        "statuses": view_statuses(found),
        "report": outcome.report,
    }
