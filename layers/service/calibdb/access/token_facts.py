"""Facts about a token and its use, for its owner."""

import time
from collections import Counter
from collections.abc import Mapping

from calibdb.access.plans import HOUR_S, KINDS, Plan
from calibdb.access.tokens import ApiToken, former_secrets
from calibdb.schema.managed_token import (
    DayOfUse,
    HourlyLimits,
    HourOfUse,
    OriginProof,
    OriginState,
    ProofFailure,
    TokenFacts,
    TokenUse,
)
from calibdb.schema.origins import proof_content, proof_url

HOURS, DAYS = 48, 30  # of use
_DAY_S = 24 * HOUR_S
_FAILURE_DETAILS: dict[ProofFailure, str] = {
    "name": "The domain name has no address.",
    "address": "The domain name has an address that is not on the public internet.",
    "connection": "The host does not accept connections at port 443, or closed one.",
    "tls": "The host's certificate is not valid for this name.",
    "timeout": "The host did not answer within 3 seconds.",
    "redirect": "The host redirects; the file must be at this very address.",
    "status": "The host did not answer with 200: the file is not there.",
    "size": "The answer is larger than 1024 bytes.",
    "answer": "The answer is not plain HTTP/1.1, or is compressed.",
    "content": "The file is there, and this line is not in it.",
}


def facts(
    token: ApiToken, allowed: Plan, now: int, failures: Mapping[str, ProofFailure] | None = None
) -> TokenFacts:
    """Describe a token; `failures`: why origins could not be verified, by origin."""
    verified = (OriginState(origin=origin, state="verified") for origin in token.origins)
    pending = (_pending(token, origin, (failures or {}).get(origin)) for origin in token.pending)
    expiries = [until for _, until in former_secrets(token) if until > now]
    return TokenFacts(
        id=token.id,
        name=token.name or None,
        plan=token.plan,
        origins=(*verified, *pending),
        created=token.created,
        expires=token.expires,
        former_until=max(expiries, default=None),
        limits=hourly_limits(allowed),
    )


def hourly_limits(allowed: Plan) -> HourlyLimits:
    """Limits of a plan as in responses."""
    return HourlyLimits.model_validate(allowed, from_attributes=True)


def _pending(token: ApiToken, origin: str, failure: ProofFailure | None) -> OriginState:
    return OriginState(
        origin=origin,
        state="pending",
        proof=OriginProof(url=proof_url(origin), content=proof_content(token.id)),
        failure=failure,
        detail=None if failure is None else _FAILURE_DETAILS[failure],
    )


def use_summary(counts: Mapping[str, Mapping[str, int]], now: int) -> TokenUse:
    """Sum counters by hour (`2026-11-22T16`, UTC) over the last 48 hours and 30 days."""
    hours = [_text("%Y-%m-%dT%H", now - back * HOUR_S) for back in reversed(range(HOURS))]
    days = [_text("%Y-%m-%d", now - back * _DAY_S) for back in reversed(range(DAYS))]
    by_day: dict[str, Counter[str]] = {day: Counter() for day in days}
    for hour, used in counts.items():
        if hour[:10] in by_day:
            by_day[hour[:10]].update(used)
    return TokenUse(
        hours=tuple(HourOfUse(hour=hour, **_by_kind(counts.get(hour, {}))) for hour in hours),
        days=tuple(DayOfUse(day=day, **_by_kind(used)) for day, used in by_day.items()),
    )


def _by_kind(used: Mapping[str, int]) -> dict[str, int]:
    return {kind: used.get(kind, 0) for kind in KINDS}


def _text(form: str, now: int) -> str:
    return time.strftime(form, time.gmtime(now))
