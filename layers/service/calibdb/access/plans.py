"""Plans: hourly limits of a token."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

HOUR_S = 3600  # period of all plans

NETWORK_SHARES = 3
"""Shares of a user that all contributors of one IPv6 line have together."""

Kind = Literal["sessions", "views", "poses", "lookups"]
KINDS: tuple[Kind, ...] = get_args(Kind)
Counter = Kind | Literal["management", "proofs", "tokens"]

MAX_MANAGEMENT_CALLS = 120  # under a management token in one hour
MAX_PROOF_CALLS = 20  # of them, those that fetch proofs
TRIAL_PERIOD_S = 30 * 24 * HOUR_S  # within which a trial token must be used once


@dataclass(frozen=True)
class Allowance:
    """Calls in one hour by kind (`schema.managed_token.PlanLimits` describes them); None: unlimited."""

    sessions: int | None
    views: int | None
    lookups: int | None
    poses: int | None


@dataclass(frozen=True)
class Plan:
    """Hourly limits of all of a token's users together, and of each one."""

    together: Allowance
    each: Allowance
    counts_each_lookup: bool = False  # stored immediately, so that its user sees it


# A capture is four to six views and a few refused ones. Calibrating all cameras in a house takes ten captures
# per hour. For each view the page requests the board's pose twice: in numbers and as an image. The token of
# a page is public: a person who copies it gets the share of one user, or of three if their line has IPv6.
_EACH = Allowance(sessions=20, views=400, lookups=600, poses=1_200)
_PARTNER = Allowance(sessions=5_000, views=100_000, lookups=2_000_000, poses=300_000)
_NONE = Allowance(None, None, None, None)

PLANS: dict[str, Plan] = {
    # New users: every page on their own machine, and programs.
    "trial": Plan(_EACH, _EACH, counts_each_lookup=True),
    "free": Plan(Allowance(sessions=60, views=1_500, lookups=10_000, poses=4_500), _EACH),
    "page": Plan(Allowance(sessions=1_000, views=25_000, lookups=200_000, poses=75_000), _EACH),
    # A private server, which sends the requests of many users from one address.
    "partner": Plan(_PARTNER, _PARTNER),
    "development": Plan(_NONE, _NONE),
}


def multiplied(factors: Iterable[tuple[str, int]]) -> dict[str, Plan]:
    """Multiply the shared limits of plans, of a plan for one user also those of each; raises ValueError."""
    result = dict(PLANS)
    for name, factor in factors:
        if name not in result:
            raise ValueError(f"there is no plan {name}")
        plan = result[name]
        each = _times(plan.each, factor) if plan.each == plan.together else plan.each
        result[name] = replace(plan, together=_times(plan.together, factor), each=each)
    return result


def _times(allowance: Allowance, factor: int) -> Allowance:
    limits = {kind: getattr(allowance, kind) for kind in KINDS}
    return Allowance(**{kind: limit and limit * factor for kind, limit in limits.items()})


def plan(name: str, plans: Mapping[str, Plan] = PLANS) -> Plan:
    """Plan, or `free` if it no longer exists."""
    return plans.get(name, plans["free"])


@dataclass(frozen=True)
class RateLimit:
    """One limit and its rest: `lookups` of the whole token, `lookups-each` of one user."""

    policy: str
    limit: int
    remaining: int
    reset_s: int


def rate_limit_headers(limits: Sequence[RateLimit]) -> dict[str, str]:
    """Two headers of a response; none if nothing is limited.

    Source: IETF draft-ietf-httpapi-ratelimit-headers-10. `q`: quota, `w`: window, s; `r`: remaining quota,
    `t`: s until it is restored.
    """
    if not limits:
        return {}
    return {
        "RateLimit-Policy": ", ".join(f'"{one.policy}";q={one.limit};w={HOUR_S}' for one in limits),
        "RateLimit": ", ".join(f'"{one.policy}";r={max(0, one.remaining)};t={one.reset_s}' for one in limits),
    }
