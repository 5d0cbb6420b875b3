"""Consensus of the calibrations of one mode, and the count of the votes on it."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence

from calibdb.camera_key import public_label, public_platform
from calibdb.compute.values import board_of, camera_of, views_of
from calibdb.rules import quality_gates
from calibdb.rules.contributed_name import most_contributed
from calibdb.rules.votes import Finding, OwnCamera, decide_vote, family, tally
from calibdb.schema import (
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    GroupsDocument,
    VoteDocument,
    Votes,
)
from calibdb.settings import Thresholds
from calibdb.store import StreamMode
from calibdb.store.keys import consensus_id
from calibsolver import CalibrationError, consensus
from calibsolver.consensus import difference
from calibsolver.fitting.board_shape import BoardShape
from calibsolver.fitting.coverage import record_covered
from calibsolver.fitting.resection import reprojection_score


def pool(
    mode: StreamMode,
    documents: Sequence[CalibrationDocument],
    model: str,
    thresholds: Thresholds,
    pool_digest: str,
) -> tuple[ConsensusDocument, GroupsDocument]:
    """Pool `documents`, all of one mode, before any vote: their consensus, and its groups and errors."""
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
    members = [one for d in documents if (one := member(d)) is not None]
    pooled, rule = functools.partial(consensus.pool, members, mode.img_size, model), rule_of(thresholds)
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
        spread=none_beyond_image(agreed.spread, mode.img_size),
        held_out_error=none_beyond_image(agreed.held_out_error, mode.img_size),
    )
    confirmable = quality_gates.is_confirmable(calibration) and (
        agreed.reason == "few_contributors"
        or (agreed.reason == "too_few" and is_consistent(agreed, pooled, rule))
    )
    sizes = ((name, none_beyond_image(error, mode.img_size)) for name, error in agreed.member_errors.items())
    errors = {name: error for name, error in sizes if error is not None}
    return (
        stored(found=agreed.reason, confirmable=confirmable, calibration=calibration),
        GroupsDocument(
            pooled=pool_digest,
            groups=agreed.groups,
            errors=errors,
            covariance=agreed.calibration.covariance.tolist(),
        ),
    )


def is_consistent(
    agreed: consensus.Consensus, pool: Callable[[consensus.Rule], consensus.Consensus], rule: consensus.Rule
) -> bool:
    """True if few calibrations would make a reliable consensus if they were enough."""
    few = dataclasses.replace(rule, min_calibrations=1, min_contributors=1)
    return agreed.consistent if rule.min_contributors < 2 else pool(few).reliable


def count(
    document: ConsensusDocument,
    votes: Sequence[VoteDocument],
    sources: frozenset[str],
    thresholds: Thresholds,
) -> Votes:
    """Score the views of every vote under the consensus as it is now, and count."""
    calibration = document.calibration
    if calibration is None:
        return Votes()
    camera = camera_of(calibration)
    width, ratio = document.img_size[0], thresholds.max_check_ratio
    findings = []
    for vote in votes:
        views = views_of(board_of(vote.board), vote.views)
        if vote.board_shape is not None:
            shape = BoardShape.from_record(vote.board_shape.model_dump())
            views = [shape.apply(view) for view in views]
        error, own, same = reprojection_score(camera, views).rms, None, False
        if vote.fit is not None:
            by_itself = camera_of(vote.fit)
            own = OwnCamera(difference(camera, by_itself), vote.fit.uncertainty.rms)
            same = by_itself.model == camera.model
        says = decide_vote(error, vote.noise, width, ratio, own, same_model=same)
        if says is not None:
            findings.append(Finding(vote.counted_as, vote.time, says))
    return tally(
        findings, calibration.calibration_time, sources, one_per_source=thresholds.contributor_period > 0
    )


def rule_of(thresholds: Thresholds) -> consensus.Rule:
    """Make the solver's rule of the deployment's thresholds."""
    names = [field.name for field in dataclasses.fields(consensus.Rule)]
    return consensus.Rule(**{name: getattr(thresholds, name) for name in names})


def member(document: CalibrationDocument) -> consensus.Member | None:
    """Convert the keypoints of one calibration for the solver; None if they are not of their board.

    No session ends like that. An imported calibration may, and must not stand in the way of the others.
    """
    try:
        views = tuple(views_of(board_of(document.board), document.views))
        return consensus.Member(document.id, document.counted_as, views, family(document.counted_as))
    except ValueError:
        return None


def none_beyond_image(px: float, img_size: tuple[int, int]) -> float | None:
    """Return a length; None if it is NaN or larger than the image, so that nothing is explained."""
    return px if px <= math.hypot(*img_size) else None
