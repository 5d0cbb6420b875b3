"""Requests and replies without a network."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from .errors import (
    ConflictError,
    CredentialError,
    FieldProblem,
    NotFoundError,
    ProblemError,
    QuotaError,
    ServiceUnavailableError,
)

Credential = Literal["token", "none"] | str
"""``token``: the API token; ``none``: no credential; anything else is a session id."""

MAX_WAIT_S = 8.0
"""Longest pause before a request is repeated; longer ones are the caller's."""
FIRST_WAIT_S = 0.25
MAX_BODY_BYTES = 32 * 1024 * 1024

_REPEATED = frozenset({429, 500, 502, 503, 504})
_ERRORS: Mapping[int, type[ProblemError]] = {
    401: CredentialError,
    403: CredentialError,
    404: NotFoundError,
    409: ConflictError,
    410: NotFoundError,
    429: QuotaError,
}


@dataclass(frozen=True)
class Request:
    """One HTTP request, relative to the address of the service. Every request of the API is idempotent."""

    method: str
    path: str
    body: Mapping[str, Any] | None = None
    query: Mapping[str, str] = field(default_factory=dict)
    credential: Credential = field(default="token", repr=False)
    accept: str = "application/json"
    repeats: bool = True


@dataclass(frozen=True)
class Reply:
    """An answer, whatever its status."""

    status: int
    headers: Mapping[str, str]
    body: bytes = field(repr=False)

    @property
    def json(self) -> dict[str, Any]:
        """The JSON object that was answered. Raises ServiceUnavailableError for anything else."""
        try:
            value = json.loads(self.body)
        except ValueError:
            value = None
        if not isinstance(value, dict):
            raise ServiceUnavailableError(
                "what answered is not the service: check the address, and proxies between here and there"
            )
        return value


@dataclass(frozen=True)
class Failure:
    """A request without an answer."""

    reason: str


def pause(outcome: Reply | Failure, attempt: int, jitter: float) -> float | None:
    """Return the seconds to wait before the request is repeated; None if it should not be.

    `attempt` counts from 0; `jitter` is random, 0 to 1, so that many clients do not return at the same
    moment.
    """
    backoff: float = min(FIRST_WAIT_S * 2**attempt, MAX_WAIT_S) * (0.5 + 0.5 * jitter)
    if isinstance(outcome, Failure):
        return backoff
    if outcome.status not in _REPEATED:
        return None
    requested = _retry_after(outcome)
    if requested is None:
        return backoff
    return requested if requested <= MAX_WAIT_S else None


def require_success(outcome: Reply | Failure, site: str) -> Reply:
    """Return a reply whose status is below 400. Raises the error that fits any other outcome."""
    if isinstance(outcome, Failure):
        raise ServiceUnavailableError(
            f"{site} does not answer ({outcome.reason}): check the address and the network, and try again"
        )
    if outcome.status < 400:
        return outcome
    raise _error_of(outcome, site)


def _error_of(reply: Reply, site: str) -> ProblemError | ServiceUnavailableError:
    """Return the error that a reply describes; a gateway's own form, or none, is understood too."""
    try:
        said = reply.json
    except ServiceUnavailableError:
        said = {}
    detail = str(said.get("detail") or said.get("message") or "")
    if reply.status >= 500:
        return ServiceUnavailableError(
            f"{site} fails at the moment ({' '.join(filter(None, (str(reply.status), detail)))}): "
            "try again in a minute"
        )
    fields = said.get("errors")
    errors = [
        FieldProblem(str(each.get("field", "")), str(each.get("detail", "")))
        for each in (fields if isinstance(fields, list) else [])
        if isinstance(each, dict)
    ]
    retry_after = _retry_after(reply)
    if reply.status == 429:
        wait = (
            f" More calls are possible in {_duration(retry_after)}."
            if retry_after
            else " Try again in a minute."
        )
        detail = (detail or "Too many requests.").rstrip() + wait
    elif reply.status in (401, 403):
        detail = (detail or "The service refuses the token.").rstrip() + " Check the token (CALIBDB_TOKEN)."
    return _ERRORS.get(reply.status, ProblemError)(
        reply.status,
        str(said.get("title") or f"HTTP {reply.status}"),
        detail or f"The service refuses the request ({reply.status}).",
        type=str(said.get("type") or "about:blank"),
        errors=errors,
        retry_after=retry_after,
        members=said,
    )


def _retry_after(reply: Reply) -> float | None:
    text = reply.headers.get("retry-after", "")
    return float(text) if text.isascii() and text.isdigit() and len(text) < 8 else None


def _duration(seconds: float) -> str:
    return f"{round(seconds)} s" if seconds < 120 else f"{-(-seconds // 60):.0f} min"
