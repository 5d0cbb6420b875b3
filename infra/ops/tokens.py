"""API tokens: issued, listed, revoked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from urllib.parse import urlsplit

import boto3

from calibdb.store import Tokens
from calibdb.tokens import ApiToken, secret_hash


def create(
    tokens: Tokens, origins: Sequence[str], plan: str, now: int, random_hex: Callable[[int], str]
) -> str:
    """Store a new token and return it. Only its hash is kept: this is the one time that it can be seen.

    Parameters
    ----------
    tokens
        Where tokens are stored.
    origins
        Web origins that may use it; none: any.
    plan
        Name of its plan.
    now
        Unix seconds.
    random_hex
        Returns so many random bytes in hex.

    Raises
    ------
    ValueError
        If something given is not an origin.
    """
    for origin in origins:
        _check(origin)
    while True:
        token_id, secret = random_hex(8), random_hex(24)
        token = ApiToken(token_id, secret_hash(secret), tuple(origins), plan, now)
        if tokens.create(token):
            return f"cdb_{token_id}_{secret}"


def every(tokens: Tokens, table_name: str) -> Iterator[ApiToken]:
    """Yield all tokens, in no order. Reads the whole index; no function has the right to."""
    pages = (
        boto3.client("dynamodb")
        .get_paginator("scan")
        .paginate(
            TableName=table_name,
            FilterExpression="begins_with(pk, :tokens) AND sk = :meta",
            ExpressionAttributeValues={":tokens": {"S": "TOKEN#"}, ":meta": {"S": "META"}},
            ProjectionExpression="pk",
        )
    )
    for page in pages:
        for item in page["Items"]:
            token = tokens.get(item["pk"]["S"].removeprefix("TOKEN#"))
            if token is not None:  # else it was revoked a moment ago
                yield token


def _check(origin: str) -> None:
    # RFC 6454, 6.2: scheme, host, port, as a browser writes them in the Origin header; no path, not even a
    # slash.
    parts = urlsplit(origin)
    if parts.scheme not in ("http", "https") or not parts.hostname or origin != origin.lower():
        raise ValueError(f"{origin!r} is not an origin such as https://example.org")
    if f"{parts.scheme}://{parts.netloc}" != origin or parts.username is not None:
        raise ValueError(f"{origin!r} has more than scheme, host and port")
