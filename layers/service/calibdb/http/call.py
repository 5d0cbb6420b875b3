"""Call of the API: credentials, body and parameters."""

from __future__ import annotations

import hmac
import math
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import from_json
from starlette.requests import Request

from calibdb.access.plans import Kind, RateLimit, rate_limit_headers
from calibdb.access.tokens import ApiToken, Ticket, parse
from calibdb.errors import (
    MAX_FIELD_ERRORS,
    CalibdbError,
    FieldError,
    ForbiddenError,
    InvalidError,
    MalformedError,
    NotAcceptableError,
    TooLargeError,
    UnauthenticatedError,
    UnavailableError,
    UnsupportedMediaTypeError,
)
from calibdb.http import metrics
from calibdb.schema.fields import MAX_INDEX
from calibdb.schema.lookup import QUERY_FLAGS
from calibdb.schema.origins import is_loopback
from calibdb.service import Service
from calibdb.store import Store

MAX_BODY_BYTES = 1_000_000  # ten times a view of the largest board

# Processor time of one request on the machine on which it was set; `Settings.processor_factor` times as much
# elsewhere. Real cameras need less.
MAX_COMPUTE_S = 2.8
MAX_RIG_COMPUTE_S = 5.2  # of a request about a rig
_MIN_REMAINING_S = 1.5  # for storage and the answer
RATE_LIMITS = "calibdb.rate_limits"  # in a request's scope: headers about the plan
_HOPS_OF_EDGE = 2  # in X-Forwarded-For: the caller, CloudFront

_WEIGHT = re.compile(r"[01](\.[0-9]{0,3})?")

Model = TypeVar("Model", bound=BaseModel)


class InLoopError(Exception):
    """The call must run in a thread."""


@dataclass(frozen=True)
class Call:
    """One request, its body read, and the service that answers it."""

    request: Request
    body: bytes
    service: Service
    processor_s: Callable[[], float] = time.thread_time
    """Processor time that this thread has used so far, s."""
    begun_s: float = field(default_factory=time.thread_time)
    """The same when the call began."""
    in_loop: bool = False
    """True in the event loop of a server."""

    @property
    def store(self) -> Store:
        """All stores of the service."""
        return self.service.store

    @property
    def now(self) -> int:
        """Unix time, whole seconds."""
        return self.service.now

    def require_thread(self) -> None:
        """Have the endpoint run again in a thread, before it waits or computes."""
        if self.in_loop:
            raise InLoopError

    def seconds_left(self) -> float:
        """Time left to compute, s: of the request's processor time, or of the invocation if less.

        In seconds of the machine on which the limits were set.
        """
        context, remaining_s = self.request.scope.get("aws.context"), math.inf
        if context is not None:
            remaining_s = context.get_remaining_time_in_millis() / 1000 - _MIN_REMAINING_S
        return min(self.processor_s_left, remaining_s / self._factor)

    def with_time_for_a_rig(self) -> Call:
        """Call with the processor time of a request about a rig."""
        return replace(self, begun_s=self.begun_s + (MAX_RIG_COMPUTE_S - MAX_COMPUTE_S) * self._factor)

    def out_of_time(self, error: CalibdbError) -> CalibdbError:
        """`error` if the processor time is used up; else UnavailableError: the machine was busy."""
        metrics.count(ComputeTimeouts=1)
        if self.processor_s_left <= 0:
            return error
        return UnavailableError("The service is too busy to compute this now; try again.")

    def charge_view(self) -> None:
        """Count the call, by session id or API token, as a view."""
        if self.is_session():
            self.session(charge="views")
        else:
            self.api_token(charge="views")

    @property
    def processor_s_left(self) -> float:
        """Processor time that is left, s of the machine on which the limits were set."""
        return MAX_COMPUTE_S - (self.processor_s() - self.begun_s) / self._factor

    @property
    def _factor(self) -> float:
        return self.service.settings.processor_factor

    def json(self, model: type[Model], depth: int | None = None) -> Model:
        """Body as `model`; raises TooLargeError, MalformedError or InvalidError.

        Of the errors whose paths begin with the same `depth` members, only the first is named.
        """
        self._require_small_body()
        try:
            return model.model_validate_json(self.body)
        except ValidationError as error:
            raise refusal(error, depth) from error

    def require_json_of_the_site(self) -> None:
        """Refuse a call without credential by a page of another origin.

        Raises UnsupportedMediaTypeError or ForbiddenError.
        """
        media_type = self.request.headers.get("content-type", "").partition(";")[0].strip().lower()
        if media_type != "application/json":
            raise UnsupportedMediaTypeError("Send the body as `Content-Type: application/json`.")
        site = self.service.settings.site_origin
        local = is_loopback(site) and self.origin is not None and is_loopback(self.origin)
        if not local and self.origin not in (None, site):
            raise ForbiddenError("Only pages of this site may make this call.", kind="origin")

    def query(self, model: type[Model]) -> Model:
        """Query as `model`; raises InvalidError."""
        try:
            return model.model_validate(dict(self.request.query_params))
        except ValidationError as error:
            raise refusal(error) from error

    def json_text(self, name: str) -> str | None:
        """Text member of the body, None if there is none."""
        self._require_small_body()
        try:
            content = from_json(self.body)
        except ValueError:
            return None
        member = content.get(name) if isinstance(content, dict) else None
        return member if isinstance(member, str) else None

    def _require_small_body(self) -> None:
        if len(self.body) > MAX_BODY_BYTES:
            raise TooLargeError(f"The body is too large; at most {MAX_BODY_BYTES} bytes are allowed.")

    def flag(self, name: str, *, default: bool = False) -> bool:
        """Query parameter that is `1` or `true`, `0` or `false`; raises InvalidError."""
        text = self.request.query_params.get(name)
        if text is None:
            return default
        if text.lower() not in QUERY_FLAGS:
            raise InvalidError.field(name, "must be 0 or 1")
        return QUERY_FLAGS[text.lower()]

    def index(self, name: str) -> int:
        """Parameter of the path that is the index of a view; raises InvalidError."""
        text = self.path(name)
        if re.fullmatch(r"[0-9]{1,9}", text, re.ASCII) is None or int(text) > MAX_INDEX:
            raise InvalidError.field(name, f"must be a whole number from 0 to {MAX_INDEX}")
        return int(text)

    def negotiate_media_type(self, types: Sequence[str]) -> str:
        """Choose the one of `types` that the caller weighs most, of equals the first; NotAcceptableError."""
        accept = self.request.headers.get("accept") or "*/*"
        weight, best = max(((_weight(accept, t), t) for t in types), key=lambda pair: pair[0])
        if weight <= 0:
            raise NotAcceptableError(f"This path offers only {', '.join(types)}; accept one of them.")
        return best

    def session(self, charge: Kind | None = None) -> Ticket:
        """Verify the session id, and count the call as one of `charge`.

        Raises UnauthenticatedError, ForbiddenError, or TooManyError.
        """
        ticket = self.service.session_ids.verify(self._bearer(), self.origin)
        token = self.service.token_of(ticket)
        if charge is not None:
            self._tell(self.service.charge(token, charge, self.address))
        return ticket

    def is_session(self) -> bool:
        """True if a session id was sent, not an API token; raises UnauthenticatedError."""
        return parse(self._bearer()) is None

    def api_token(self, credential: str | None = None, charge: Kind = "lookups") -> ApiToken:
        """API token sent as bearer, else `credential`; counts the call as one of `charge`.

        Raises UnauthenticatedError, ForbiddenError, or TooManyError.
        """
        if credential is None or "authorization" in self.request.headers:
            credential = self._bearer()
        token = self.service.api_token(credential, self.require_thread)
        # The site's own pages try calls with a visitor's token, whatever its origins.
        if not token.admits(self.origin) and self.origin != self.service.settings.site_origin:
            if self.origin in token.pending:
                raise ForbiddenError(
                    "Pages of this origin may use the API token once the origin is verified: place "
                    "the proof, then POST /v1/tokens/self/verify.",
                    kind="origin-unverified",
                )
            raise ForbiddenError("The API token does not admit pages of this origin.", kind="origin")
        if charge == "lookups":
            if RATE_LIMITS not in self.request.scope:  # else it was counted before it required a thread
                if self.service.plan_of(token).counts_each_lookup and not self.service.writes_later:
                    self.require_thread()
                self._tell(self.service.count_lookup(token, self.address))
        else:
            self._tell(self.service.charge(token, charge, self.address))
        return token

    def managed_token(self) -> ApiToken:
        """Token, revoked or not, of the management token sent as bearer; counts the call."""
        token = self.service.managed_token(self._bearer())
        self.service.limit_management(token)
        return token

    def _tell(self, limits: Sequence[RateLimit]) -> None:
        """Report what is left of the plan in the response."""
        self.request.scope[RATE_LIMITS] = rate_limit_headers(limits)

    @property
    def origin(self) -> str | None:
        """Origin of the page that asks, None outside a browser."""
        return self.request.headers.get("origin")

    @property
    def address(self) -> str:
        """Source address, only ever used inside a keyed hash.

        Anyone can write X-Forwarded-For. Only behind our CloudFront, recognised by a secret, do its last two
        entries count: the caller's, appended by CloudFront, and CloudFront's, by the gateway.
        """
        shown = self.request.headers.get("x-calibdb-edge", "").encode()
        secrets = self.service.settings.edge_secrets
        if any(hmac.compare_digest(shown, secret.encode()) for secret in secrets):
            hops = self.request.headers.get("x-forwarded-for", "").split(",")
            if len(hops) >= _HOPS_OF_EDGE:
                return hops[-_HOPS_OF_EDGE].strip()
        elif shown and secrets:  # our distribution with an unknown secret, or a guess
            metrics.count(UnknownEdges=1)
        return self.request.client.host if self.request.client else ""

    def contributor(self, ticket: Ticket) -> tuple[str, str]:
        """Keyed hashes of the contributor and of their source."""
        return self.service.contributor(self.address, ticket.token), self.service.source(self.address)

    def path(self, name: str) -> str:
        """Parameter of the path."""
        return str(self.request.path_params[name])

    def _bearer(self) -> str:
        scheme, _, credential = self.request.headers.get("authorization", "").partition(" ")
        if scheme.lower() != "bearer" or not credential.strip():
            raise UnauthenticatedError("Send the credential as `Authorization: Bearer …`.")
        return credential.strip()


def _weight(accept: str, media_type: str) -> float:
    """Weight of the most specific range of `accept` that contains `media_type` (RFC 9110, 12.5.1), else 0."""
    ranges = {}
    for entry in accept.lower().split(","):
        name, *parameters = (part.strip() for part in entry.split(";"))
        weights = [p[2:] for p in parameters if p.startswith("q=")]
        ranges[name] = float(weights[0]) if weights and _WEIGHT.fullmatch(weights[0]) else 1.0
    family = media_type.partition("/")[0] + "/*"
    return next((ranges[r] for r in (media_type, family, "*/*") if r in ranges), 0.0)


def refusal(error: ValidationError, depth: int | None = None) -> CalibdbError:
    """Error of invalid fields, without a word of Python; `depth`: as of `Call.json`."""
    problems = error.errors(include_url=False, include_input=False, include_context=False)
    if any(p["type"] == "json_invalid" for p in problems):
        return MalformedError("The body is not JSON.")
    inside = {p["loc"][:depth] for p in problems for depth in range(len(p["loc"]))}
    said = [p for p in problems if p["type"] != "too_short" or p["loc"] not in inside]  # wrong, not missing
    if depth is not None:
        said = list({p["loc"][:depth]: p for p in reversed(said)}.values())[::-1]
    return InvalidError(
        [
            FieldError(".".join(map(str, p["loc"])) or "body", _plain(p["msg"]))
            for p in said[:MAX_FIELD_ERRORS]
        ]
    )


def _plain(text: str) -> str:
    text = text.removeprefix("Value error, ").partition(" after validation")[0]
    return f"List{text.removeprefix('Tuple')}" if text.startswith("Tuple ") else text
