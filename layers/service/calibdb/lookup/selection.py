"""Selection of the consensus that a lookup returns, among all of a camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from calibdb.schema import ConsensusDocument
from calibdb.schema.lookup import Reason

# Log of the ratio of two aspects below which they are one: 854x480 and 1280x720 differ by 0.07 %, 4:3 and 5:4
# by 6.5 %.
_MAX_ASPECT_LOG = 0.01


@dataclass(frozen=True)
class Choice:
    """Selected consensus, or a size at which the model is yet to be computed, or the reason for a miss."""

    found: ConsensusDocument | None = None
    missing_at: tuple[int, int] | None = None
    reason: Reason = "unknown_camera"


def choose(known: Sequence[ConsensusDocument], img_size: tuple[int, int], zoom: float, model: str) -> Choice:
    """Select the result of a lookup.

    Parameters
    ----------
    known
        All consensuses of the camera.
    img_size, zoom, model
        The request. Another zoom is other optics and never a result. The exact size comes first, then
        the closest: by aspect, then by area.

    Returns
    -------
    Choice
        `found`: a reliable consensus. `missing_at`: nothing is stored for this model at the best size at
        which another model has a consensus. Else `reason`, of the exact size where it is known.

    """
    here: dict[tuple[tuple[int, int], str], ConsensusDocument] = {
        (c.img_size, c.distortion_model): c for c in known if c.zoom == zoom
    }
    for size in sorted({size for size, _ in here}, key=lambda s: closeness(s, img_size)):
        requested = here.get((size, model))
        if requested is not None and requested.reliable:
            return Choice(found=requested)
        others = [c for (other, _), c in here.items() if other == size and c.reliable]
        # Not computed yet, or not since the calibrations came in that made another model reliable.
        if any(
            requested is None or (requested.total, requested.latest) < (c.total, c.latest) for c in others
        ):
            return Choice(missing_at=size)
    order = sorted(here.items(), key=lambda known: known[0][1] != model)
    exact = [c.reason for (size, _), c in order if size == img_size and c.reason]
    return Choice(reason=exact[0] if exact else "too_few" if here else "unknown_camera")


def closeness(size: tuple[int, int], requested: tuple[int, int]) -> tuple[bool, float, float]:
    """Sort key of sizes by closeness: the same first, then by aspect, then by area."""
    aspect = 0.0 if same_aspect(size, requested) else _aspect_log(size, requested)
    area = abs(math.log(size[0] * size[1] / (requested[0] * requested[1])))
    return size != requested, aspect, area


def same_aspect(one: tuple[int, int], other: tuple[int, int]) -> bool:
    """True if two sizes have one aspect."""
    return _aspect_log(one, other) < _MAX_ASPECT_LOG


def _aspect_log(one: tuple[int, int], other: tuple[int, int]) -> float:
    return abs(math.log(one[0] * other[1] / (one[1] * other[0])))
