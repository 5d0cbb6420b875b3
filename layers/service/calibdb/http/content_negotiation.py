"""Content negotiation: the media type of a response by the Accept header (RFC 9110, 12.5.1)."""

from __future__ import annotations

import re
from collections.abc import Sequence

from calibdb.errors import NotAcceptableError

_WEIGHT = re.compile(r"[01](\.[0-9]{0,3})?")


def negotiate(accept: str, types: Sequence[str]) -> str:
    """Choose the one of `types` that `accept` weighs most; of equals the first.

    Raises NotAcceptableError when `accept` wants none of them.
    """
    weight, best = max(((_weight(accept, t), t) for t in types), key=lambda pair: pair[0])
    if weight <= 0:
        raise NotAcceptableError(f"This path offers only {', '.join(types)}; accept one of them.")
    return best


def _weight(accept: str, media_type: str) -> float:
    """Weight of the most specific range of `accept` that contains `media_type`; 0 if there is none."""
    ranges = {}
    for entry in accept.lower().split(","):
        name, *parameters = (part.strip() for part in entry.split(";"))
        weights = [p[2:] for p in parameters if p.startswith("q=")]
        ranges[name] = float(weights[0]) if weights and _WEIGHT.fullmatch(weights[0]) else 1.0
    family = media_type.partition("/")[0] + "/*"
    return next((ranges[r] for r in (media_type, family, "*/*") if r in ranges), 0.0)
