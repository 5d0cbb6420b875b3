"""Token of the site's own pages: it follows the site's address."""

from __future__ import annotations

import functools
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from calibdb.access.tokens import ApiToken, parse, secret_hash
from calibdb.store import Objects, Table, Tokens, clients

_PLAN = "page"
_ID_BYTES, _SECRET_BYTES = 8, 24


def current(made: Mapping[str, str], region: str, settings: Mapping[str, str] | None) -> str:
    """Return the token that the pages of a stack are given, valid on every address of the site.

    Parameters
    ----------
    made
        Outputs of the stack.
    settings
        The deployed `/config.json`, None where there is none.
    """
    table = Table(functools.partial(clients.dynamodb, region), made["TableName"])
    objects = Objects(functools.partial(clients.s3, region), made["KeypointBucketName"])
    origins = dict.fromkeys([made["SiteUrl"], f"https://{made['DistributionDomain']}"])
    return admit(Tokens(table, objects), (settings or {}).get("token", ""), tuple(origins))


def admit(tokens: Tokens, known: str, origins: Sequence[str]) -> str:
    """Return a token that admits pages of `origins`: the known one, changed if need be, or a new one."""
    parts = parse(known)
    token = tokens.get(parts[0]) if parts else None
    if token is not None:
        if missing := [origin for origin in origins if origin not in token.origins]:
            tokens.change(replace(token, origins=(*token.origins, *missing)))
        return known
    while True:
        token_id, secret = secrets.token_hex(_ID_BYTES), secrets.token_hex(_SECRET_BYTES)
        token = ApiToken(token_id, secret_hash(secret), tuple(origins), _PLAN, int(time.time()))
        if tokens.create(token):
            return f"cdb_{token_id}_{secret}"
