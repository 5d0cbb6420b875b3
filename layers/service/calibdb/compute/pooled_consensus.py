"""Consensus of the calibrations of one mode, and the count of the votes on it."""

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from calibdb.camera_key import public_label, public_platform
from calibdb.compute.values import board_of, camera_of, views_of
from calibdb.rules import quality_gates
from calibdb.rules.contributed_name import most_contributed
from calibdb.rules.votes import Finding, OwnCamera, decide_vote, expected_error, family, tally
from calibdb.schema import (
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    GroupsDocument,
    ShapeDocument,
    ViewDocument,
    VoteDocument,
    Votes,
)
from calibdb.schema.board import Board
from calibdb.settings import Thresholds
from calibdb.store import StreamMode
from calibdb.store.keys import consensus_id
from calibsolver import CalibrationError, consensus
from calibsolver.consensus import difference
from calibsolver.fitting.board_shape import BoardShape
from calibsolver.fitting.coverage import record_covered
from calibsolver.fitting.resection import reprojection_score


@dataclass(frozen=True)
class MeasuredViews:
    """Fresh views without misread corners."""

    views: tuple[ViewDocument, ...]
    noise: float
    """px rms under a camera fitted to them."""
    own: FitRecord | None
    """That camera; None if part of the image is undetermined."""
    board_shape: ShapeDocument | None
    """Shape of the board that both refer to; None: as drawn."""


@dataclass(frozen=True)
class Score:
    """Score of a consensus on views; `fits`: None if they do not tell."""

    fits: bool | None
    error: float  # px
    expected: float  # px


def pool(
    mode: StreamMode,
    documents: Sequence[CalibrationDocument],
    model: str,
    thresholds: Thresholds,
    pool_digest: str,
) -> tuple[ConsensusDocument, GroupsDocument]:
    """Pool the calibrations of a mode: their consensus before any vote, and its groups."""
    stored = functools.partial(
        ConsensusDocument,
        camera_key=mode.camera_key,
        img_size=mode.img_size,
        zoom=mode.zoom,
        distortion_model=model,
        total=len(documents),
        latest=max((d.time for d in documents), default=0),
        pooled=pool_digest,
    )
    members = [one for d in documents if (one := _member(d)) is not None]
    names = [field.name for field in dataclasses.fields(consensus.Rule)]
    rule = consensus.Rule(**{name: getattr(thresholds, name) for name in names})
    pooled = functools.partial(consensus.pool, members, mode.img_size, model)
    try:
        agreed = pooled(rule)
    except CalibrationError:
        outcome = "too_few" if len(documents) < rule.min_calibrations else "disagree"
        return stored(found=outcome, reason=outcome), GroupsDocument(pooled=pool_digest)
    group = [d for d in documents if d.id in agreed.members]
    calibration = Calibration.of(
        FitRecord.model_validate(record_covered(agreed.calibration, agreed.coverage)),
        id=consensus_id(mode.camera_key, mode.img_size, mode.zoom, model),
        camera=most_contributed(group, lambda d: public_label(d.camera)),
        platform=most_contributed(group, lambda d: public_platform(d.platform)),
        zoom=mode.zoom,
        calibration_time=max(d.time for d in group),
        calibrations=len(agreed.members),
        contributors=agreed.contributors,
        spread=_limited(agreed.spread, mode),
        held_out_error=_limited(agreed.held_out_error, mode),
    )
    confirmable = quality_gates.is_confirmable(calibration) and (
        agreed.reason == "few_contributors"
        or (agreed.reason == "too_few" and _is_consistent(agreed, pooled, rule))
    )
    limited = {name: _limited(error, mode) for name, error in agreed.member_errors.items()}
    errors = {name: error for name, error in limited.items() if error is not None}
    return (
        stored(found=agreed.reason, confirmable=confirmable, calibration=calibration),
        GroupsDocument(
            pooled=pool_digest,
            groups=agreed.groups,
            errors=errors,
            covariance=agreed.calibration.covariance.tolist(),
        ),
    )


def _is_consistent(
    agreed: consensus.Consensus, pool: Callable[[consensus.Rule], consensus.Consensus], rule: consensus.Rule
) -> bool:
    """True if only the number of calibrations is too small."""
    few = dataclasses.replace(rule, min_calibrations=1, min_contributors=1)
    return agreed.consistent if rule.min_contributors < 2 else pool(few).reliable


def score(board: Board, measured: MeasuredViews, consensus: Calibration, max_ratio: float) -> Score:
    """Score a consensus on views; only the poses are fitted to them."""
    camera, (width, height), own, same_model = camera_of(consensus), consensus.img_size, None, False
    views = views_of(board_of(board), measured.views)
    if measured.board_shape is not None:
        shape = BoardShape.from_record(measured.board_shape.model_dump())
        views = [shape.apply(view) for view in views]
    error = reprojection_score(camera, views).rms
    if measured.own is not None:
        by_itself = camera_of(measured.own)
        own = OwnCamera(difference(camera, by_itself), measured.own.uncertainty.rms)
        same_model = by_itself.model == camera.model
    says = decide_vote(error, measured.noise, width, max_ratio, own, same_model=same_model)
    return Score(says, min(error, math.hypot(width, height)), expected_error(measured.noise, width))


def count(
    document: ConsensusDocument,
    votes: Sequence[VoteDocument],
    sources: frozenset[str],
    thresholds: Thresholds,
) -> Votes:
    """Count the votes by the scores of their views."""
    calibration = document.calibration
    if calibration is None:
        return Votes()
    findings = []
    for vote in votes:
        measured = MeasuredViews(vote.views, vote.noise, vote.fit, vote.board_shape)
        fits = score(vote.board, measured, calibration, thresholds.max_check_ratio).fits
        if fits is not None:
            findings.append(Finding(vote.counted_as, vote.time, fits))
    return tally(
        findings, calibration.calibration_time, sources, one_per_source=thresholds.contributor_period > 0
    )


def _member(document: CalibrationDocument) -> consensus.Member | None:
    """Calibration for the solver; None if its corners are not of its board, as of imports."""
    try:
        views = tuple(views_of(board_of(document.board), document.views))
        return consensus.Member(document.id, document.counted_as, views, family(document.counted_as))
    except ValueError:
        return None


def _limited(px: float, mode: StreamMode) -> float | None:
    """Length; None if it is NaN or larger than the image."""
    return px if px <= math.hypot(*mode.img_size) else None
