"""Refit: the consensus of the calibrations of one camera, at one size and zoom. Internal.

It is idempotent and safe to run late, or at the same time as another: a result is written only over one
made from less. With nothing new, it answers what is stored. A request from the queue takes the single-flight
lease; where another holds it, the request marks the lease and ends, and the holder goes round once more. One
that fails every time goes to the dead-letter queue. What is computed stays. The edge answers as it does.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any

from calibdb.errors import UnavailableError
from calibdb.http import metrics
from calibdb.lookup import well_known_ids
from calibdb.rules import quality_gates
from calibdb.rules.contributed_name import most_contributed_label, most_contributed_platform
from calibdb.rules.refit_plan import Step, input_digest, plan_refit, pool_digest
from calibdb.rules.sources import family
from calibdb.rules.votes import Finding, OwnCamera, decide_vote, tally, with_votes
from calibdb.schema import (
    DISTORTION_MODELS,
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    FittingGroup,
    GroupsDocument,
    ModeViews,
    RefitAnswer,
    RefitRequest,
    VoteDocument,
    Votes,
)
from calibdb.service import Service
from calibdb.settings import Thresholds
from calibdb.store import IndexedVote, StreamMode
from calibdb.store.aliases import Alias
from calibdb.store.calibrations import CountedCalibration
from calibdb.store.keys import consensus_id
from calibsolver import FIT_VERSION, Board, CalibrationError, Camera, DeadlineError, View, consensus, deadline
from calibsolver.consensus import difference
from calibsolver.consensus import mode as mode_of_camera
from calibsolver.fitting.board_shape import BoardShape
from calibsolver.fitting.coverage import record_covered
from calibsolver.fitting.resection import reprojection_score

MAX_ROUNDS = 5  # of one computation for others who ask meanwhile; then it is their turn
WAITS_S = (0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 2.0, 2.0, 2.0)  # for the same computation; a caller has 25 s
MAX_ATTEMPTS = 5  # while other writers keep winning the conditional put
MIN_PUBLISHING_S = 8.0  # of an invocation, kept for storage, the edge and the answer

POOLING_VERSION = 6  # of pooling and counting: results of another version are recomputed

Consensuses = dict[str, ConsensusDocument | None]
Stored = Mapping[str, ConsensusDocument]
Guard = AbstractContextManager[None] | None


@metrics.counting_denied_reads
def handler(event: dict[str, Any], context: Any) -> dict[str, Any]:
    """Compute, store and return the consensus of every model asked for; null where nothing is known.

    From the queue of those that failed, an event holds one record of a request.
    """
    if "Records" in event:
        (record,) = event["Records"]
        event = json.loads(record["body"])["requestPayload"]
    request = RefitRequest.model_validate(event)
    service = Service.of(os.environ)
    mode = StreamMode(request.camera, request.img_size, request.zoom)
    consensuses: Consensuses = {}
    fitting = None
    with deadline.limit(lambda: context.get_remaining_time_in_millis() / 1000 - MIN_PUBLISHING_S):
        if request.misses:
            service.store.miss_counts.add(request.misses, service.now)
        elif request.alias is not None:
            alias = Alias(request.alias.label, request.alias.platform)
            service.store.aliases.record(alias, request.camera, request.alias.source, service.now)
        elif request.queued:
            run_under_lease(service, mode, context)
        else:
            models = [m for m in DISTORTION_MODELS if m in request.models or not request.models]
            consensuses = ensure_current(service, mode, models, _alone(service, mode, models, context))
            document = consensuses.get(models[0]) if request.seen and models else None
            fitting = fitting_group(service, document, request.seen) if document and request.seen else None
    return RefitAnswer.model_validate({"models": consensuses, "fitting": fitting}).model_dump(mode="json")


@contextmanager
def _alone(service: Service, mode: StreamMode, models: Sequence[str], context: Any) -> Iterator[None]:
    """Wait until nobody else computes the same for somebody who waits; raises UnavailableError.

    Clients that lost patience ask again; without this, each of them would start the computation anew. Who
    waited mostly finds it done.
    """
    leases, me, name = service.store.leases, str(context.aws_request_id), f"NOW#{'+'.join(models)}"
    for pause in (*WAITS_S, None):
        if leases.take(mode, me, service.now, _deadline(service, context), name):
            break
        if pause is None:
            raise UnavailableError("This consensus is still being computed; try again.")
        time.sleep(pause)
    try:
        yield
    finally:
        leases.abandon(mode, me, name)


def _deadline(service: Service, context: Any) -> int:
    """Unix seconds at which this invocation has surely ended."""
    left_ms: int = context.get_remaining_time_in_millis()
    return service.now + math.ceil(left_ms / 1000)


def run_under_lease(service: Service, mode: StreamMode, context: Any) -> None:
    """Refresh every model's consensus, unless the holder of the lease will do so for this request."""
    leases, me = service.store.leases, str(context.aws_request_id)
    until = _deadline(service, context)
    if not leases.take(mode, me, service.now, until):
        return
    done = False
    try:
        for _ in range(MAX_ROUNDS):
            ensure_current(service, mode, DISTORTION_MODELS)
            done = leases.release(mode, me)
            if done:
                return
            leases.again(mode, me, until)
    finally:
        if not done:
            leases.abandon(mode, me)
    # The queue delivers this request again, after a while, and whoever asks until then begins anew.
    raise UnavailableError("New calibrations of this camera keep arriving; try again.")


def ensure_current(
    service: Service, mode: StreamMode, models: Sequence[str], guard: Guard = None
) -> Consensuses:
    """Return each model's consensus as it follows from the index; compute and store those that are stale.

    `guard`: entered before anything is computed; reads alone need none.
    """
    with ExitStack() as guarded:
        if guard is not None:
            consensuses = _try_once(service, mode, models, compute=False)
            if consensuses is not None:
                return consensuses
            guarded.enter_context(guard)
        for _ in range(MAX_ATTEMPTS):
            consensuses = _try_once(service, mode, models, compute=True)
            if consensuses is not None:
                return consensuses
    raise UnavailableError("Other computations keep updating this consensus; try again.")


def _try_once(
    service: Service, mode: StreamMode, models: Sequence[str], *, compute: bool
) -> Consensuses | None:
    """Do what `ensure_current` does; None if another writer won a conditional put.

    Where not to `compute`, None also where something is stale.
    """
    store, thresholds = service.store, service.settings.thresholds
    # Stored consensuses are read first: each was made from what is read after it, or from less.
    stored: Stored = {c.distortion_model: c for c in store.consensuses.at(mode)}
    counted = store.calibrations.newest(mode, thresholds.max_calibrations, thresholds.contributor_period)
    if not counted:
        return _drop(service, mode, models, stored)
    votes = store.votes.newest(mode, one_per_source=thresholds.contributor_period > 0)
    pooled = pool_digest(POOLING_VERSION, [c.id for c in counted], thresholds, FIT_VERSION)
    basis = input_digest(pooled, [vote.id for vote in votes])
    steps = plan_refit(models, stored, pooled, basis)
    if not compute and any(step.action != "keep" for step in steps):
        return None
    return _apply(service, Inputs(mode, counted, votes, pooled, basis), steps)


@dataclasses.dataclass(frozen=True)
class Inputs:
    """Calibrations and votes of a mode that its consensuses are computed from, and their digests."""

    mode: StreamMode
    counted: Sequence[CountedCalibration]
    votes: Sequence[IndexedVote]
    pool_digest: str
    input_digest: str


def _apply(service: Service, inputs: Inputs, steps: Sequence[Step]) -> Consensuses | None:
    """Compute and store what `steps` ask for; None if another writer won a conditional put.

    Raises UnavailableError where the time is up. What was stored until then is whole.
    """
    store, thresholds, mode = service.store, service.settings.thresholds, inputs.mode
    documents = functools.cache(lambda: store.calibrations.read([c.id for c in inputs.counted]))
    votes = functools.cache(lambda: store.votes.read(inputs.votes))
    sources = frozenset(c.source for c in inputs.counted)
    consensuses: Consensuses = {}
    written, late = 0, False
    for step in steps:
        document, groups = step.stored, None
        if step.action != "keep":
            try:
                if step.action == "pool" or document is None:
                    document, groups = pool(mode, documents(), step.model, thresholds, inputs.pool_digest)
                counts = count(document, votes() if inputs.votes else [], sources, thresholds)
            except DeadlineError:
                late = True
                break
            document = with_votes(document, counts, inputs.input_digest, thresholds)
            if not store.consensuses.put(document, groups, step.stored.basis if step.stored else None):
                break
            written += 1
        consensuses[step.model] = document
    # Even when another writer won: it may have looked before the first of these was written.
    if written:
        well_known_ids.refresh_well_known(store, mode.camera_key, thresholds)
    if late:
        raise UnavailableError("This consensus takes longer to compute than is left; try again.")
    return consensuses if len(consensuses) == len(steps) else None


def _drop(service: Service, mode: StreamMode, models: Sequence[str], stored: Stored) -> Consensuses | None:
    """Drop the consensuses of a mode without calibrations; None if another writer changed one meanwhile."""
    gone = [stored[model] for model in models if model in stored]
    dropped = all(map(service.store.consensuses.drop, gone))
    if gone and dropped:
        well_known_ids.refresh_well_known(service.store, mode.camera_key, service.settings.thresholds)
    return dict.fromkeys(models) if dropped else None


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
        found = "too_few" if len(documents) < rule.min_calibrations else "disagree"
        return stored(found=found, reason=found), GroupsDocument(pooled=pool_digest)
    group = [d for d in documents if d.id in agreed.members]
    calibration = Calibration.of(
        FitRecord.model_validate(record_covered(agreed.calibration, agreed.coverage)),
        id=consensus_id(mode.camera_key, mode.img_size, mode.zoom, model),
        camera=most_contributed_label(group),
        platform=most_contributed_platform(group),
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
    """Tell whether few calibrations would make a reliable consensus if they were enough."""
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
    camera = Camera.from_record(calibration.model_dump())
    width, ratio = document.img_size[0], thresholds.max_check_ratio
    findings = []
    for vote in votes:
        views = views_of(vote)
        if vote.board_shape is not None:
            shape = BoardShape.from_record(vote.board_shape.model_dump())
            views = [shape.apply(view) for view in views]
        error, own, same = reprojection_score(camera, views).rms, None, False
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
    """Make the solver's rule of the deployment's thresholds."""
    names = [field.name for field in dataclasses.fields(consensus.Rule)]
    return consensus.Rule(**{name: getattr(thresholds, name) for name in names})


def member(document: CalibrationDocument) -> consensus.Member | None:
    """Convert the keypoints of one calibration for the solver; None where they are not of their board.

    No session ends like that. An imported calibration may, and must not stand in the way of the others.
    """
    try:
        return consensus.Member(
            document.id, document.counted_as, tuple(views_of(document)), family(document.counted_as)
        )
    except ValueError:
        return None


def views_of(document: CalibrationDocument | VoteDocument) -> list[View]:
    """Convert a document's views for the solver; raises ValueError."""
    board = Board.from_record(document.board.model_dump())
    return board.views([view.model_dump() for view in document.views])


def fitting_group(service: Service, document: ConsensusDocument, seen: ModeViews) -> FittingGroup | None:
    """Return the one group of calibrations that fits the views, by its most certain calibration.

    None if no group does, or several do. Nothing is stored.
    """
    behind = service.store.consensuses.groups(document)
    if behind is None or len(behind.groups) < 2:
        return None
    ids = [one for group in behind.groups for one in group]
    documents = {d.id: d for d in service.store.calibrations.read(ids)}
    groups = [[documents[one] for one in group if one in documents] for group in behind.groups]
    model = document.distortion_model

    def rank(d: CalibrationDocument) -> tuple[bool, float]:
        return d.distortion_model != model, d.fits[d.distortion_model].uncertainty.rms

    known = [min(group, key=rank).answer() for group in groups if group]
    cameras = [Camera.from_record(one.model_dump()) for one in known]
    try:
        views = Board.from_record(seen.board).views([view.model_dump() for view in seen.views])
        index = mode_of_camera.fitting_camera(cameras, views, model)
    except (CalibrationError, ValueError):
        return None
    if index is None:
        return None
    count = len([group for group in groups if group][index])
    calibration = known[index].model_copy(update={"calibrations": count})
    return FittingGroup(calibration=calibration, groups=len(known))


def none_beyond_image(px: float, img_size: tuple[int, int]) -> float | None:
    """Return a length; None where it is NaN or larger than the image, so that nothing is explained."""
    return px if px <= math.hypot(*img_size) else None
