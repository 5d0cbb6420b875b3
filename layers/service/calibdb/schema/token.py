"""An API token as it is stored: `tokens/<id>.json`. Its secrets are not in it."""

from __future__ import annotations

from typing import Literal

from calibdb.schema.fields import Open


class TokenDocument(Open):
    """Times are unix seconds."""

    layout: Literal[1] = 1
    id: str
    secret_sha256: str
    origins: tuple[str, ...] = ()
    plan: str = "free"
    created: int = 0
    former_sha256: str | None = None
    former_until: int = 0
    earlier: tuple[tuple[str, int], ...] = ()
    pending: tuple[str, ...] = ()
    management_sha256: str | None = None
    name: str = ""
    expires: int | None = None
    version: int = 0
    revoked: int | None = None
