"""Lookup of one camera: what is answered for a label, platform, size, zoom and model, or why nothing is.

Lookups and the answers at the edge are made here alone, so that they cannot differ.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from calibdb.camera_key import identify
from calibdb.lookup import camera_lookup
from calibdb.lookup.answer import bracketing_zooms, build_answer, interpolate_zoom
from calibdb.schema import ConsensusDocument, LookupAnswer
from calibdb.schema.lookup import Reason
from calibdb.store import CameraRecords

_NO_CALIBRATION = "The database has no reliable calibration of this camera."
_MISS_DETAILS = {
    "unknown_camera": _NO_CALIBRATION,
    "too_few": "The database has too few calibrations of this camera.",
    "disagree": "The calibrations of this camera disagree.",
    "few_contributors": "The calibrations of this camera come from too few contributors.",
    "imprecise": "The calibrations of this camera agree, and leave it too uncertain.",
}

Compute = Callable[[str, tuple[int, int]], ConsensusDocument | None]
"""Camera key and size to the consensus of the model asked for, computed now; None if there is none."""


@dataclass(frozen=True)
class LookupQuery:
    """Camera, size, zoom and model that are looked up."""

    camera: str
    platform: str
    img_size: tuple[int, int]
    zoom: float
    model: str
    resize_mode: str | None = None


@dataclass(frozen=True)
class LookupResult:
    """Answer of a lookup, or the reason why there is none.

    Attributes
    ----------
    key
        Of the camera whose calibrations answer; empty where the camera cannot be known.
    answer
        None: nothing is known that is good enough.
    reason, detail
        Why, then, by name and in words.
    known
        All consensuses of the camera, then: evidence for an estimate.
    """

    key: str
    answer: LookupAnswer | None
    reason: Reason = "unknown_camera"
    detail: str = _NO_CALIBRATION
    known: Sequence[ConsensusDocument] = ()


def find(
    read: Callable[[str], CameraRecords], wanted: LookupQuery, *, private: bool, compute: Compute
) -> LookupResult:
    """Find what a lookup answers.

    Parameters
    ----------
    read
        Returns what is known under a camera key.
    wanted
        What is asked for.
    private
        The database of one person, who has few cameras, and knows which is meant.
    compute
        Computes a model on its first request.
    """
    size, zoom, model = wanted.img_size, wanted.zoom, wanted.model
    identity = identify(wanted.camera, wanted.platform)
    why = camera_lookup.unanswerable_reason(identity, private=private, resize_mode=wanted.resize_mode)
    if why is not None:
        return LookupResult("", None, detail=why)
    resolved = camera_lookup.resolve(read, identity, size, zoom, model, private=private)
    found, reason = resolved.choice.found, resolved.choice.reason
    if resolved.choice.missing_at is not None:
        # A model that was not requested before can be computed from the stored keypoints.
        found = compute(resolved.key, resolved.choice.missing_at)
        reason = found.reason if found and found.reason else reason
    if found is not None and found.reliable and found.calibration is not None:
        return LookupResult(resolved.key, build_answer(found.calibration, resolved.known, size))
    around = bracketing_zooms(resolved.known, size, zoom, model)
    if around is not None:
        return LookupResult(resolved.key, interpolate_zoom(*around, zoom))
    detail = camera_lookup.SEVERAL if resolved.several else _MISS_DETAILS[reason]
    return LookupResult(resolved.key, None, reason, detail, resolved.known)
