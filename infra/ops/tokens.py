"""API tokens: issued, listed, exchanged, revoked."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from urllib.parse import urlsplit

from calibdb.access.plans import PLANS
from calibdb.access.tokens import ApiToken, secret_hash
from infra.ops.desk import Desk, OpsError

_SECRET = 24  # bytes


def create(desk: Desk, origins: Sequence[str], plan: str) -> str:
    """Store a new token and return it. Only its hash is kept: this is the one time that it can be seen.

    Raises OpsError where an origin is none, or the plan is not known.
    """
    for origin in origins:
        _check(origin)
    if plan not in PLANS:
        raise OpsError(f"there is no plan {plan!r}; there are {', '.join(PLANS)}")
    while True:
        token_id, secret = desk.random_hex(8), desk.random_hex(_SECRET)
        token = ApiToken(token_id, secret_hash(secret), tuple(origins), plan, desk.now)
        if desk.store.tokens.create(token):
            return f"cdb_{token_id}_{secret}"


def listed(desk: Desk) -> list[str]:
    """Return a line for each token, oldest first."""
    return [
        "  ".join(
            (
                token.id,
                time.strftime("%Y-%m-%d", time.gmtime(token.created)),
                token.plan,
                " ".join(token.origins) or "any origin",
            )
        )
        for token in sorted(desk.store.tokens.all(), key=lambda token: (token.created, token.id))
    ]


def rotate(desk: Desk, token_id: str, grace: float) -> str:
    """Give the token another secret and return it; the one before opens for `grace` hours more.

    A third is refused at once: of two exchanges within the grace, the second ends what the first left open.
    """
    token = _known(desk, token_id)
    secret = desk.random_hex(_SECRET)
    desk.store.tokens.change(
        replace(
            token,
            secret_sha256=secret_hash(secret),
            former_sha256=token.secret_sha256,
            former_until=desk.now + int(grace * 3600),
        )
    )
    return f"cdb_{token_id}_{secret}"


def revoke(desk: Desk, token_id: str) -> None:
    """Refuse the token from now on, for good: its id is never another's."""
    desk.store.tokens.revoke(_known(desk, token_id), desk.now)


def _known(desk: Desk, token_id: str) -> ApiToken:
    token = desk.store.tokens.get(token_id)
    if token is None:
        raise OpsError(f"there is no token {token_id}")
    return token


def _check(origin: str) -> None:
    # RFC 6454, 6.2: scheme, host, port, as a browser writes them in the Origin header; no path, not even a
    # slash.
    parts = urlsplit(origin)
    if parts.scheme not in ("http", "https") or not parts.hostname or origin != origin.lower():
        raise OpsError(f"{origin!r} is not an origin such as https://example.org")
    if f"{parts.scheme}://{parts.netloc}" != origin or parts.username is not None:
        raise OpsError(f"{origin!r} has more than scheme, host and port")
