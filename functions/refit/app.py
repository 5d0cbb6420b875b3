"""Computes what the calibrations of one camera, at one size and zoom, agree on. Internal.

Safe to run twice, late, or at the same time as another: a result is written only over one that was made from
less. Asked again with nothing new, it answers what is stored. Asked through the queue while another
computation of the same is under way, it leaves word and ends, and the other goes round once more: of a
hundred captures that end together, one computation serves all.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import math
import os
from collections.abc import Sequence
from typing import Any

from calibdb.errors import UnavailableError
from calibdb.lookup import well_known_ids
from calibdb.rules import quality_gates
from calibdb.rules.votes import Finding, OwnCamera, decide_vote, tally, with_votes
from calibdb.schema import (
    DISTORTION_MODELS,
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    GroupsDocument,
    RefitAnswer,
    RefitRequest,
    VoteDocument,
    Votes,
)
from calibdb.service import Service
from calibdb.settings import Thresholds
from calibdb.store import StreamMode
from calibdb.store.keys import consensus_id
from calibsolver import Board, CalibrationError, Camera, View, __version__, consensus
from calibsolver.consensus import difference
from calibsolver.fitting.resection import reprojection_score

ROUNDS = 5  # of one computation for others who ask meanwhile; then it is their turn
ATTEMPTS = 5  # of one that others keep overtaking

METHOD = 3  # of pooling and counting: what another one computed is computed anew

Answer = dict[str, ConsensusDocument | None]


def handler(event: dict[str, Any], context: Any) -> dict[str, Any]:
    """Compute, store and return the consensus of every model asked for; null where nothing is known."""
    request = RefitRequest.model_validate(event)
    service = Service.of(os.environ)
    mode = StreamMode(request.camera, request.img_size, request.zoom)
    if request.queued:
        in_turn(service, mode, context)
        return RefitAnswer(models={}).model_dump(mode="json")
    models = [m for m in DISTORTION_MODELS if m in request.models or not request.models]
    return RefitAnswer.model_validate({"models": current(service, mode, models)}).model_dump(mode="json")


def in_turn(service: Service, mode: StreamMode, context: Any) -> None:
    """Bring every model's consensus up to date, unless another computation does and can do it along."""
    leases, me = service.store.leases, str(context.aws_request_id)
    until = service.now + math.ceil(context.get_remaining_time_in_millis() / 1000)
    if not leases.take(mode, me, service.now, until):
        return
    done = False
    try:
        for _ in range(ROUNDS):
            current(service, mode, DISTORTION_MODELS)
            done = leases.release(mode, me)
            if done:
                return
            leases.again(mode, me, until)
    finally:
        if not done:
            leases.abandon(mode, me)
    # The queue delivers this request again, after a while, and whoever asks until then begins anew.
    raise UnavailableError("Calibrations of this camera keep coming in.")


def current(service: Service, mode: StreamMode, models: Sequence[str]) -> Answer:
    """Return each model's consensus as it must be by what is in the index, stored if it was not."""
    for _ in range(ATTEMPTS):
        answer = attempt(service, mode, models)
        if answer is not None:
            return answer
    raise UnavailableError("Others keep computing the consensus of this camera.")


def attempt(service: Service, mode: StreamMode, models: Sequence[str]) -> Answer | None:
    """Return what `current` does; None when it was overtaken."""
    store, thresholds = service.store, service.settings.thresholds
    # First of all: whatever is stored by now was made from what is read after it, or from less.
    stored: dict[str, ConsensusDocument] = {c.distortion_model: c for c in store.consensuses.at(mode)}
    counted = store.calibrations.newest(mode, thresholds.most_calibrations, thresholds.contributor_period)
    if not counted:
        gone = [stored[model] for model in models if model in stored]
        if not all(map(store.consensuses.drop, gone)):
            return None
        if gone:
            well_known_ids.refresh_well_known(store, mode.camera_key, thresholds)
        return dict.fromkeys(models)
    cast = store.votes.newest(mode, one_per_source=thresholds.contributor_period > 0)
    pooled = digest(METHOD, [c.id for c in counted], rule_of(thresholds), thresholds, __version__)
    basis = digest(pooled, [vote.id for vote in cast])

    documents = functools.cache(lambda: store.calibrations.read([c.id for c in counted]))
    votes = functools.cache(lambda: store.votes.read(cast))
    sources = frozenset(c.source for c in counted)
    answer: Answer = {}
    overtaken = False
    for model in models:
        known = stored.get(model)
        if known is not None and known.basis == basis:
            answer[model] = known
            continue
        groups = None
        if known is not None and known.pooled == pooled:
            document = known  # only the votes are others
        else:
            document, groups = pool(mode, documents(), model, thresholds, pooled)
        found = count(document, votes() if cast else [], sources, thresholds)
        document = with_votes(document, found, basis, thresholds)
        if not store.consensuses.put(document, groups, known.basis if known else None):
            overtaken = True
            break
        answer[model] = document
    # Overtaken, too: who was quicker may have looked before the first of these was written.
    if any(known is not stored.get(model) for model, known in answer.items()):
        well_known_ids.refresh_well_known(store, mode.camera_key, thresholds)
    return None if overtaken else answer


def pool(
    mode: StreamMode,
    documents: Sequence[CalibrationDocument],
    model: str,
    thresholds: Thresholds,
    pooled: str,
) -> tuple[ConsensusDocument, GroupsDocument]:
    """Return what `documents`, all of one mode, agree on, before any vote, and what is behind it."""
    stored = functools.partial(
        ConsensusDocument,
        camera_key=mode.camera_key,
        img_size=mode.img_size,
        zoom=mode.zoom,
        distortion_model=model,
        total=len(documents),
        latest=max((d.time for d in documents), default=0),
        pooled=pooled,
    )
    members = [one for d in documents if (one := member(d)) is not None]
    rule = rule_of(thresholds)
    try:
        agreed = consensus.pool(members, mode.img_size, model, rule)
    except CalibrationError:
        found = "too_few" if len(documents) < rule.min_calibrations else "disagree"
        return stored(found=found, reason=found), GroupsDocument(pooled=pooled)
    newest = max((d for d in documents if d.id in agreed.members), key=lambda d: (d.time, d.id))
    calibration = Calibration.of(
        FitRecord.model_validate(agreed.calibration.record()),
        id=consensus_id(mode.camera_key, mode.img_size, mode.zoom, model),
        camera=newest.camera,
        platform=newest.platform,
        zoom=mode.zoom,
        calibration_time=newest.time,
        calibrations=len(agreed.members),
        contributors=agreed.contributors,
        spread=within(agreed.spread, mode.img_size),
        held_out_error=within(agreed.held_out_error, mode.img_size),
    )
    confirmable = quality_gates.is_confirmable(calibration) and (
        agreed.reason == "few_contributors"
        or (agreed.reason == "too_few" and consistent(members, mode, model, rule))
    )
    sizes = ((name, within(error, mode.img_size)) for name, error in agreed.member_errors.items())
    errors = {name: error for name, error in sizes if error is not None}
    return (
        stored(found=agreed.reason, confirmable=confirmable, calibration=calibration),
        GroupsDocument(pooled=pooled, groups=agreed.groups, errors=errors),
    )


def consistent(
    members: Sequence[consensus.Member], mode: StreamMode, model: str, rule: consensus.Rule
) -> bool:
    """Tell whether few calibrations would make a reliable consensus if they were enough."""
    few = dataclasses.replace(rule, min_calibrations=1, min_contributors=1)
    return consensus.pool(members, mode.img_size, model, few).reliable


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
    camera = Camera.from_record(calibration.model_dump())
    width, ratio = document.img_size[0], thresholds.max_check_ratio
    findings = []
    for vote in votes:
        error, own, same = reprojection_score(camera, views_of(vote)).rms, None, False
        if vote.fit is not None:
            by_itself = Camera.from_record(vote.fit.model_dump())
            own = OwnCamera(difference(camera, by_itself), vote.fit.uncertainty.rms)
            same = by_itself.model == camera.model
        says = decide_vote(error, vote.noise, width, ratio, own, same_model=same)
        if says is not None:
            findings.append(Finding(vote.counted_as, vote.time, says))
    return tally(
        findings, calibration.calibration_time, sources, one_per_source=thresholds.contributor_period > 0
    )


def rule_of(thresholds: Thresholds) -> consensus.Rule:
    """Return the solver's rule by the deployment's thresholds."""
    names = [field.name for field in dataclasses.fields(consensus.Rule)]
    return consensus.Rule(**{name: getattr(thresholds, name) for name in names})


def member(document: CalibrationDocument) -> consensus.Member | None:
    """Return the keypoints of one calibration for the solver; None where they are not of their board.

    No session ends like that, but what was brought in from elsewhere may, and must not stand in the way of
    the others.
    """
    try:
        return consensus.Member(document.id, document.counted_as, tuple(views_of(document)))
    except ValueError:
        return None


def views_of(document: CalibrationDocument | VoteDocument) -> list[View]:
    """Convert a document's views for the solver; raises ValueError."""
    board = Board.from_record(document.board.model_dump())
    return board.views([view.model_dump() for view in document.views])


def digest(*parts: object) -> str:
    """Return what stands for `parts`."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def within(px: float, img_size: tuple[int, int]) -> float | None:
    """Return a length, None where it is no number or larger than the image: then nothing is explained."""
    return px if px <= math.hypot(*img_size) else None
