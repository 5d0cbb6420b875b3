"""Tokens that people make for themselves: requests and responses."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import Label, Open, Strict, UnixTime
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
TokenName = Annotated[
    Annotated[Label, Field(max_length=MAX_NAME)] | None, Field(description="Label that only you see.")
]
TokenId = Annotated[str, Field(description="Name of the token; not secret.")]
NewToken = Annotated[str, Field(description="The API token, shown only once.")]


class TokenRequest(Strict):
    """A new token."""

    origins: Origins
    name: TokenName = None


class TokenChange(Strict):
    """Change of a token; what is left out stays."""

    origins: Origins | None = Field(None, description="All origins from now on.")
    name: TokenName = None


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

    url: str = Field(description="Required address of the proof.")
    content: str = Field(description="Required line of the proof.")


class OriginState(Open):
    """One origin of a token."""

    origin: str = Field(description="Origin of pages, `https://page.example`.")
    state: Literal["verified", "pending"] = Field(
        description="`verified`: pages may use the token. `pending`: the proof is missing."
    )
    proof: OriginProof | None = Field(None, description="File to place at a pending origin.")
    failure: ProofFailure | None = Field(None, description="Reason why no proof was found.")
    detail: str | None = Field(None, description="Explanation for people.")


_SESSIONS = "Captures opened."
_VIEWS = "Views submitted, undone, checked; calibrations converted."
_POSES = "Target poses and their images; captures started, read and deleted."
_LOOKUPS = "Lookups and other reads."


class PlanLimits(Open):
    """Calls in one hour by kind; null: as many as are wanted."""

    sessions: int | None = Field(description=_SESSIONS)
    views: int | None = Field(description=_VIEWS)
    poses: int | None = Field(description=_POSES)
    lookups: int | None = Field(description=_LOOKUPS)


class HourlyLimits(Open):
    """Limits of all users of a token together, and of each one."""

    together: PlanLimits = Field(description="All users of the token.")
    each: PlanLimits = Field(description="Each user.")


class UseCounts(Open):
    """Calls by kind. Lookups are written down in batches, so that the last ones may be missing."""

    sessions: int = Field(0, description=_SESSIONS)
    views: int = Field(0, description=_VIEWS)
    poses: int = Field(0, description=_POSES)
    lookups: int = Field(0, description=_LOOKUPS)


class HourOfUse(UseCounts):
    """Calls of one hour, UTC."""

    hour: str = Field(examples=["2026-11-22T16"], description="Hour, UTC.")


class DayOfUse(UseCounts):
    """Calls of one day, UTC."""

    day: str = Field(examples=["2026-11-22"], description="Day, UTC.")


class TokenUse(Open):
    """Calls of the last two days by hour, and of the last 30 days by day; the oldest first."""

    hours: tuple[HourOfUse, ...] = Field(description="The last two days.")
    days: tuple[DayOfUse, ...] = Field(description="The last thirty days.")


class TokenFacts(Open):
    """All about a token but its secrets. Times are unix seconds."""

    id: TokenId
    name: str | None = Field(description="Label that only you see.")
    plan: str = Field(description="Plan of the token.")
    origins: tuple[OriginState, ...] = Field(
        description="Origins whose pages may use the token, each with its state."
    )
    created: UnixTime
    expires: int | None = Field(description="Expiry of an unused trial token, unix seconds.")
    former_until: int | None = Field(description="Expiry of the previous secret, unix seconds.")
    limits: HourlyLimits = Field(description="Limits of the plan, by hour.")


class ManagedToken(TokenFacts):
    """All about a token, with its use."""

    use: TokenUse = Field(description="Calls by hour and by day.")


class TokenCreated(TokenFacts):
    """A new token. Both secrets are shown this once."""

    token: NewToken
    management_token: str = Field(
        description="Secret that manages the token, shown only once. Keep it out of pages."
    )


class TokenRotated(Open):
    """The token with its new secret, shown this once."""

    id: TokenId
    token: NewToken
    former_until: int | None = Field(
        description="Expiry of the previous secret, unix seconds; null: expired."
    )


class UsageAnswer(Open):
    """Use of a token in this hour."""

    plan: str = Field(description="Plan of the token.")
    period_s: int = Field(description="Length of the period that the limits are for, seconds.")
    resets_at: int = Field(description="Start of the next hour, unix seconds.")
    limits: HourlyLimits = Field(description="Limits of the plan, by hour.")
    used: UseCounts = Field(description="Use by all users of the token.")
    used_here: UseCounts = Field(description="Use from your address, without lookups.")


class ProofRequest(Strict):
    """Request to the function that fetches proofs."""

    token_id: str = Field(max_length=64)
    origin: Origin


class ProofAnswer(Open):
    """Result of a search for a proof; found if there is no failure."""

    failure: ProofFailure | None = None
