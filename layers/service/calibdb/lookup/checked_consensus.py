"""Consensus that a check is about: found as a lookup finds it, but at no other size or zoom."""

from __future__ import annotations

from collections.abc import Sequence

from calibdb.camera_key import identify
from calibdb.errors import NotFoundError
from calibdb.lookup.camera_match import resolve, unanswerable_reason
from calibdb.schema import Calibration, CheckRequest, ConsensusDocument
from calibdb.store import Store, StreamMode


def find_checked(store: Store, request: CheckRequest, *, private: bool) -> tuple[StreamMode, Calibration]:
    """Find the consensus to check, reliable or not, and its mode; raises NotFoundError if there is none.

    It is found as a lookup would find it, but at no other size or zoom than the views'. As in a lookup, what
    a browser cropped is another picture.
    """
    size, zoom, model = request.img_size, request.zoom, request.distortion_model
    identity = identify(request.camera, request.platform)
    if unanswerable_reason(identity, private=private, resize_mode=request.resize_mode) is None:
        read = store.cameras.known
        resolved = resolve(read, identity, size, zoom, model, private=private)
        mode = StreamMode(resolved.key, size, zoom)
        here = [c for c in resolved.known if (c.img_size, c.zoom) == (size, zoom)]
        consensus = consensus_of_model(here, model) or (store.refit.consensus(mode, model) if here else None)
        if consensus is not None and consensus.calibration is not None:
            return mode, consensus.calibration
    raise NotFoundError(
        "The database has no consensus to check for this camera at this size; cropped streams have none.",
        kind="no-calibration",
    )


def consensus_of_model(documents: Sequence[ConsensusDocument], model: str) -> ConsensusDocument | None:
    """Return the consensus of this model, None if there is none."""
    return next((d for d in documents if d.distortion_model == model), None)
