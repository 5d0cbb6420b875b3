"""Tokens that people make for themselves: requests and answers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import Label, Open, Strict
from calibdb.schema.origins import MAX_ORIGIN_LENGTH, ORIGIN_PATTERN, requirement

MAX_ORIGINS = 10
DEFAULT_GRACE_S, MAX_GRACE_S = 86_400, 30 * 86_400
MAX_NAME = 80  # characters

ProofFailure = Literal[
    "name", "address", "connection", "tls", "timeout", "redirect", "status", "size", "answer", "content"
]


def _nameable(origin: str) -> str:
    wrong = requirement(origin)
    if wrong is not None:
        raise PydanticCustomError("origin", wrong)
    return origin


def _different(origins: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(origins)) != len(origins):
        raise PydanticCustomError("duplicate_origins", "an origin appears more than once")
    return origins


Origin = Annotated[
    str,
    Field(
        max_length=MAX_ORIGIN_LENGTH,
        examples=["http://localhost", "https://example.org"],
        json_schema_extra={"pattern": ORIGIN_PATTERN},
    ),
    AfterValidator(_nameable),
]
Origins = Annotated[
    tuple[Origin, ...],
    Field(
        min_length=1,
        max_length=MAX_ORIGINS,
        description="Origins whose pages may use the token, as browsers write them. An origin of this "
        "machine without a port, as `http://localhost`, stands for all of its ports.",
    ),
    AfterValidator(_different),
]
TokenName = Annotated[Label, Field(max_length=MAX_NAME, description="Label that only you see.")]


class TokenRequest(Strict):
    """A new token."""

    origins: Origins
    name: TokenName | None = None


class TokenChange(Strict):
    """Change of a token; what is left out stays."""

    origins: Origins | None = None
    name: TokenName | None = None


class RotationRequest(Strict):
    """Exchange of the secret."""

    grace_s: int = Field(
        DEFAULT_GRACE_S,
        ge=0,
        le=MAX_GRACE_S,
        description="Seconds for which the previous secret still works; 0 ends all earlier secrets.",
    )


class OriginProof(Open):
    """File that proves an origin: `content` is one of its lines."""

    url: str
    content: str


class OriginState(Open):
    """One origin of a token."""

    origin: str
    state: Literal["verified", "pending"]
    proof: OriginProof | None = Field(None, description="File to place at a pending origin.")
    failure: ProofFailure | None = Field(None, description="Reason why no proof was found.")
    detail: str | None = Field(None, description="Explanation for people.")


class PlanLimits(Open):
    """Calls in one hour by kind; null: as many as are wanted."""

    sessions: int | None
    views: int | None
    poses: int | None
    lookups: int | None


class HourlyLimits(Open):
    """Limits of all users of a token together, and of each one."""

    together: PlanLimits
    each: PlanLimits


class UseCounts(Open):
    """Calls by kind. Lookups are written down in batches, so that the last ones may be missing."""

    sessions: int = 0
    views: int = 0
    poses: int = 0
    lookups: int = 0


class HourOfUse(UseCounts):
    """Calls of one hour, UTC."""

    hour: str = Field(examples=["2026-11-22T16"])


class DayOfUse(UseCounts):
    """Calls of one day, UTC."""

    day: str = Field(examples=["2026-11-22"])


class TokenUse(Open):
    """Calls of the last two days by hour, and of the last 30 days by day; the oldest first."""

    hours: tuple[HourOfUse, ...]
    days: tuple[DayOfUse, ...]


class TokenFacts(Open):
    """All about a token but its secrets. Times are unix seconds."""

    id: str
    name: str | None
    plan: str
    origins: tuple[OriginState, ...]
    created: int
    expires: int | None = Field(description="Expiry of an unused trial token, unix seconds.")
    former_until: int | None = Field(description="Expiry of the previous secret, unix seconds.")
    limits: HourlyLimits


class ManagedToken(TokenFacts):
    """All about a token, with its use."""

    use: TokenUse


class TokenCreated(TokenFacts):
    """A new token. Both secrets are shown this once."""

    token: str
    management_token: str


class TokenRotated(Open):
    """The token with its new secret, shown this once."""

    id: str
    token: str
    former_until: int | None


class UsageAnswer(Open):
    """Use of a token in this hour."""

    plan: str
    period_s: int
    resets_at: int = Field(description="Start of the next hour, unix seconds.")
    limits: HourlyLimits
    used: UseCounts = Field(description="Use by all users of the token.")
    used_here: UseCounts = Field(description="Use from your address, without lookups.")


class ProofRequest(Strict):
    """Asks the function that fetches proofs."""

    token_id: str = Field(max_length=64)
    origin: Origin


class ProofAnswer(Open):
    """Result of a look for a proof; without a failure it was found."""

    failure: ProofFailure | None = None
