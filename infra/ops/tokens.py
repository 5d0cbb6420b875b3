"""API tokens: creation, listing, rotation, revocation."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from urllib.parse import urlsplit

from calibdb.access.plans import HOUR_S, PLANS
from calibdb.access.token_facts import use_summary
from calibdb.access.tokens import ApiToken, secret_hash, with_secret
from calibdb.schema.managed_token import TokenUse
from calibdb.store import Tokens
from infra.ops import OpsError
from infra.ops.context import OpsContext

_ID_BYTES, _SECRET_BYTES = 8, 24


def create(context: OpsContext, origins: Sequence[str], plan: str) -> str:
    """Store a new token and return it. Only its hash is stored, so it cannot be shown again.

    Raises OpsError if an origin is none, or the plan is not known.
    """
    for origin in origins:
        _check(origin)
    if plan not in PLANS:
        raise OpsError(f"there is no plan {plan!r}; there are {', '.join(PLANS)}")
    return issue(context.store.tokens, origins, plan, context.now, context.random_hex)


def issue(
    tokens: Tokens, origins: Sequence[str], plan: str, now: int, random_hex: Callable[[int], str]
) -> str:
    """Store a new token under a random id and return it."""
    while True:
        token_id, secret = random_hex(_ID_BYTES), random_hex(_SECRET_BYTES)
        if tokens.create(ApiToken(token_id, secret_hash(secret), tuple(origins), plan, now)):
            return f"cdb_{token_id}_{secret}"


def list_all(context: OpsContext) -> list[ApiToken]:
    """List the tokens that work, oldest first."""
    return sorted(context.store.tokens.all(), key=lambda token: (token.created, token.id))


def describe(token: ApiToken) -> tuple[str, str, str, str, str]:
    """Describe a token: id, day, plan, creator, origins."""
    day = time.strftime("%Y-%m-%d", time.gmtime(token.created))
    made_by = "operator" if token.management_sha256 is None else "itself"
    origins = [*token.origins, *(f"{origin} (pending)" for origin in token.pending)]
    return token.id, day, token.plan, made_by, " ".join(origins) or "any origin"


def use(context: OpsContext, token_id: str) -> TokenUse:
    """Sum up the use of a token by hour and by day."""
    return use_summary(context.store.quotas.use(token_id, context.now), context.now)


def get(context: OpsContext, token_id: str) -> ApiToken:
    """Read a token; raises OpsError if there is none."""
    token = context.store.tokens.get(token_id)
    if token is None:
        raise OpsError(f"there is no token {token_id}")
    return token


def rotate(context: OpsContext, token_id: str, grace: float) -> str:
    """Give the token another secret and return it; the old one still works for `grace` hours.

    Every earlier secret works until its own time ends, and for `grace` at most; 0 ends them all.
    """
    token = get(context, token_id)
    secret = context.random_hex(_SECRET_BYTES)
    context.store.tokens.update(
        token.id,
        lambda known: with_secret(known, secret_hash(secret), context.now, int(grace * HOUR_S)),
    )
    return f"cdb_{token_id}_{secret}"


def revoke(context: OpsContext, token_id: str) -> None:
    """Refuse the token from now on, for good: its id is never another's."""
    context.store.tokens.revoke(get(context, token_id), context.now)


def _check(origin: str) -> None:
    # RFC 6454, 6.2: scheme, host, port, as a browser writes them in the Origin header; no path, not even a
    # slash.
    parts = urlsplit(origin)
    if parts.scheme not in ("http", "https") or not parts.hostname or origin != origin.lower():
        raise OpsError(f"{origin!r} is not an origin such as https://example.org")
    if f"{parts.scheme}://{parts.netloc}" != origin or parts.username is not None:
        raise OpsError(f"{origin!r} has more than scheme, host and port")
