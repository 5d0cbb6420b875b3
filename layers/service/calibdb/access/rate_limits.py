"""Rate limits of a plan, as answers tell them.

Source: IETF draft-ietf-httpapi-ratelimit-headers-10, `RateLimit-Policy` and `RateLimit`: lists of structured
fields (RFC 9651), one item a policy. `q`: quota, `w`: window, s; `r`: remaining quota, `t`: s until it is
restored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from calibdb.access.plans import HOUR_S


@dataclass(frozen=True)
class RateLimit:
    """One limit and what is left of it: `lookups` of the whole token, `lookups-each` of one user."""

    policy: str
    limit: int
    remaining: int
    reset_s: int


def rate_limit_headers(limits: Sequence[RateLimit]) -> dict[str, str]:
    """Return the two headers; none where nothing is limited."""
    if not limits:
        return {}
    return {
        "RateLimit-Policy": ", ".join(f'"{one.policy}";q={one.limit};w={HOUR_S}' for one in limits),
        "RateLimit": ", ".join(f'"{one.policy}";r={max(0, one.remaining)};t={one.reset_s}' for one in limits),
    }
