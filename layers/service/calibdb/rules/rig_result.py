"""Result of a finished rig."""

from collections.abc import Sequence

from calibdb.errors import ConflictError
from calibdb.rules.rig_rules import MIN_AGREEING_VIEWS
from calibdb.rules.rig_state import Rig, named, state, unit
from calibdb.schema import (
    RigCalibrationDocument,
    RigEstimateDocument,
    RigResult,
)
from calibdb.schema.rig import Extrinsics, MomentPose, Motion, RigVerdict, RigVerdictReason
from calibdb.schema.rig_documents import EndingDocument, RigFit

MAX_FAIR_RATIO = 3.0  # predicted error / target error of a fair rig
MAX_HELD_OUT_RATIO = 2.0  # error of moments outside the fit / inside it, of a good rig
MAX_SET_ASIDE_SHARE = 0.25  # of the views of a good rig


def require_finishable(rig: Rig, estimate: RigEstimateDocument) -> RigFit:
    """Fit of a rig that can end; raises ConflictError."""
    if estimate.unlinked:
        lost = named(estimate.unlinked)
        raise ConflictError(
            f"{lost} shared no moment with the others: hold the board where both see it.", kind="unlinked"
        )
    fit = estimate.fit
    few = [i for i, n in enumerate(rig.count_agreeing(fit)) if n < MIN_AGREEING_VIEWS]
    few += [i for i, s in enumerate(rig.sessions) if i not in few and (s is None or s.estimate.fit is None)]
    if few:
        raise ConflictError(
            f"{named(sorted(few))} fewer than {MIN_AGREEING_VIEWS} views that agree. Capture more moments.",
            kind="too-few-views",
        )
    if fit is None:
        raise ConflictError(
            f"The cameras cannot be fitted together: {estimate.problem}. Capture more moments.",
            kind="too-few-views",
        )
    return fit


def finished(
    rig: Rig,
    estimate: RigEstimateDocument,
    fit: RigFit,
    endings: Sequence[EndingDocument],
    solver: str,
    now: int,
) -> RigCalibrationDocument:
    """Document of a rig that ends now."""
    running = state(rig, estimate)
    update = {
        "status": "finished",
        "cameras": tuple(c.model_copy(update={"status": "finished"}) for c in running.cameras),
        "progress": 1.0,
        "target": None,
        "result": _result(rig, fit, endings, now),
    }
    return RigCalibrationDocument(
        id=rig.document.rig,
        time=now,
        solver=solver,
        contributors=tuple(m.contributor if m else "" for m in rig.document.members),
        state=running.model_copy(update=update),
    )


def _result(rig: Rig, fit: RigFit, endings: Sequence[EndingDocument], now: int) -> RigResult:
    scale = rig.document.square_size or 1.0
    ids = tuple(ending.finish.calibration_id for ending in endings)
    return RigResult(
        rig_id=rig.document.rig,
        cameras=ids,
        calibrations=tuple(
            session.calibrated(record, ids[position], now)
            for (position, session), record in zip(rig.present, fit.cameras, strict=True)
        ),
        extrinsics=_extrinsics(fit, scale),
        unit=unit(rig.document),
        rms=fit.rms,
        held_out_rms=fit.held_out_rms,
        uncertainty=fit.uncertainty,
        verdict=_verdict(rig, fit),
        board_poses=tuple(
            MomentPose(moment=one.moment, rvec=one.pose[:3], tvec=_scaled(one.pose, scale)[3:])
            for one in fit.board_poses
        ),
        board_shape=fit.board_shape,
    )


def _extrinsics(fit: RigFit, scale: float) -> tuple[Extrinsics, ...]:
    return tuple(
        Extrinsics(position=i, rvec=pose[:3], tvec=_scaled(pose, scale)[3:], std=_scaled(std, scale))
        for i, (pose, std) in enumerate(zip(fit.poses, fit.std, strict=True))
    )


def _scaled(motion: Motion, scale: float) -> Motion:
    """Multiply the translation."""
    x, y, z = motion[3:]
    return (*motion[:3], x * scale, y * scale, z * scale)


def _verdict(rig: Rig, fit: RigFit) -> RigVerdict:
    """Judge a rig by its expected error and by contradictions."""
    reasons: list[RigVerdictReason] = []
    if fit.uncertainty.rms > rig.target_error:
        reasons.append("uncertain")
    if fit.held_out_rms is not None and fit.held_out_rms > MAX_HELD_OUT_RATIO * fit.rms:
        reasons.append("held_out")
    views = sum(len(by_position) for _, by_position in rig.moments())
    if len(fit.set_aside) > MAX_SET_ASIDE_SHARE * views:
        reasons.append("set_aside")
    if not reasons:
        return RigVerdict(level="good")
    poor = fit.uncertainty.rms > MAX_FAIR_RATIO * rig.target_error
    return RigVerdict(level="poor" if poor else "fair", reasons=tuple(reasons))
