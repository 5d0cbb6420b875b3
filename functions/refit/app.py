"""Computes what the calibrations of one camera, at one size and zoom, agree on. Internal.

Safe to run twice, late, or at the same time as another: a result that considered fewer calibrations never
replaces one that considered more. Asked again with nothing new, it answers what is stored: of a hundred
requests that a busy camera leaves in the queue, the first does the work of all.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Sequence
from typing import Any

from calibdb.schema import (
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    RefitAnswer,
    RefitRequest,
)
from calibdb.schema.lookup import Reason
from calibdb.service import Service
from calibdb.store.keys import consensus_id
from calibsolver import Board, CalibrationError, __version__, consensus

MOST = 200  # the newest; more make no consensus better


def handler(event: dict[str, Any], _: object) -> dict[str, Any]:
    """Compute, store and return the consensus of every model asked for; null where nothing is known."""
    request = RefitRequest.model_validate(event)
    service = Service.of(os.environ)
    rule = consensus.Rule(
        min_calibrations=service.settings.thresholds.min_calibrations,
        min_contributors=service.settings.thresholds.min_contributors,
    )
    ids = service.store.calibrations.newest(request.camera, request.img_size, request.zoom, MOST)
    basis = hashlib.sha256(repr((ids, rule, __version__)).encode()).hexdigest()
    answer: dict[str, ConsensusDocument | None] = dict.fromkeys(request.models)
    for known in service.store.consensuses.of(request.camera) if ids else ():
        here = (known.img_size, known.zoom) == (request.img_size, request.zoom)
        if here and known.basis == basis and known.distortion_model in answer:
            answer[known.distortion_model] = known
    missing = [model for model, known in answer.items() if known is None]
    documents = service.store.calibrations.read(ids) if missing else []
    for model in missing if documents else ():
        pooled = pool(documents, model, rule).model_copy(update={"basis": basis})
        service.store.consensuses.put(pooled)
        answer[model] = pooled
    return RefitAnswer.model_validate({"models": answer}).model_dump(mode="json")


def pool(documents: Sequence[CalibrationDocument], model: str, rule: consensus.Rule) -> ConsensusDocument:
    """Return what `documents`, all of one camera, size and zoom, agree on."""
    first = documents[0]
    stored = functools.partial(
        ConsensusDocument,
        camera_key=first.camera_key,
        img_size=first.img_size,
        zoom=first.zoom,
        distortion_model=model,
        total=len(documents),
        latest=max(d.time for d in documents),
    )
    try:
        agreed = consensus.pool([member(d) for d in documents], first.img_size, model, rule)
    except CalibrationError:
        return stored(reason="too_few" if len(documents) < rule.min_calibrations else "disagree")
    newest = max((d for d in documents if d.id in agreed.members), key=lambda d: (d.time, d.id))
    calibration = Calibration.of(
        FitRecord.model_validate(agreed.calibration.record()),
        id=consensus_id(first.camera_key, first.img_size, first.zoom, model),
        camera=newest.camera,
        platform=newest.platform,
        zoom=first.zoom,
        calibration_time=newest.time,
        calibrations=len(agreed.members),
        contributors=agreed.contributors,
        reliable=agreed.reliable,
    )
    return stored(calibration=calibration, reason=None if agreed.reliable else doubt(agreed, rule))


def doubt(agreed: consensus.Consensus, rule: consensus.Rule) -> Reason:
    """Return why a consensus is not called reliable."""
    if agreed.total < rule.min_calibrations:
        return "too_few"
    if len(agreed.members) < max(rule.min_calibrations, rule.min_share * agreed.total):
        return "disagree"
    if agreed.contributors < rule.min_contributors:
        return "few_contributors"
    return "disagree"


def member(document: CalibrationDocument) -> consensus.Member:
    """Return the keypoints of one calibration for the solver."""
    board = Board(**document.board.model_dump())
    views = tuple(board.view(view.ids, view.points) for view in document.views)
    return consensus.Member(document.id, document.contributor, views)
