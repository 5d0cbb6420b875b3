"""Errors of the service: one tree, each error with the problem document that the caller gets.

An error is raised where it is known, with the words a caller needs, and becomes an answer in one place
(`calibdb.http`), as RFC 9457 `application/problem+json`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pydantic import JsonValue

MAX_FIELD_ERRORS = 20  # in one answer; of a body with ten thousand wrong points the first few say enough
PROBLEMS = "/docs/problems/#"  # on the site: the page that says what to do about each kind


@dataclass(frozen=True)
class FieldError:
    """One field of a request and what is wrong with it; `field` is its path, joined by dots."""

    field: str
    detail: str


class CalibdbError(Exception):
    """Base of all errors that a caller receives: status, problem type and title by class, detail by instance.

    Parameters
    ----------
    detail
        One sentence about this occurrence. Never contains what the caller sent, except names of fields.
    kind
        Last part of the problem's type where one class stands for several problems.
    fields
        Problem of each field (`errors` of the response).
    headers
        Headers that the response must have, such as `WWW-Authenticate`.
    extensions
        Extension members of the problem document (RFC 9457, 3.2).

    """

    status = 500
    kind = "internal"
    title = "Internal error"

    def __init__(
        self,
        detail: str,
        *,
        kind: str | None = None,
        fields: Sequence[FieldError] = (),
        headers: Mapping[str, str] | None = None,
        extensions: Mapping[str, JsonValue] | None = None,
    ) -> None:
        super().__init__(detail)
        self.detail = detail
        self.kind = kind or type(self).kind
        self.fields = tuple(fields)
        self.headers = dict(headers or {})
        self.extensions = dict(extensions or {})

    def problem(self) -> dict[str, JsonValue]:
        """Return the problem document, as RFC 9457 names its members; `type` relative to the site."""
        document: dict[str, JsonValue] = {
            "type": PROBLEMS + self.kind,
            "title": self.title,
            "status": self.status,
            "detail": self.detail,
        }
        if self.fields:
            document["errors"] = [{"field": f.field, "detail": f.detail} for f in self.fields]
        return {**document, **self.extensions}


class MalformedError(CalibdbError):
    """The body is not JSON."""

    status, kind, title = 400, "malformed", "Not JSON"


class UnauthenticatedError(CalibdbError):
    """No credential was sent."""

    status, kind, title = 401, "unauthenticated", "Credential missing"

    def __init__(self, detail: str) -> None:
        super().__init__(detail, headers={"WWW-Authenticate": 'Bearer realm="calibDB"'})


class ForbiddenError(CalibdbError):
    """A credential was sent, and it does not open this: unknown, expired, or not from this origin."""

    status, kind, title = 403, "forbidden", "Credential refused"


class NotFoundError(CalibdbError):
    """There is no such thing."""

    status, kind, title = 404, "not-found", "Not found"


class NotAcceptableError(CalibdbError):
    """None of the media types that the caller accepts can be given."""

    status, kind, title = 406, "not-acceptable", "Not acceptable"


class ConflictError(CalibdbError):
    """The request does not fit the state that things are in."""

    status, kind, title = 409, "conflict", "Conflict"


class GoneError(CalibdbError):
    """There was such a thing, and it was taken back."""

    status, kind, title = 410, "gone", "Withdrawn"


class TooLargeError(CalibdbError):
    """The body is larger than anything this call can mean."""

    status, kind, title = 413, "too-large", "Body too large"


class UnsupportedMediaTypeError(CalibdbError):
    """The body is of another media type than JSON."""

    status, kind, title = 415, "unsupported-media-type", "Not declared as JSON"


class InvalidError(CalibdbError):
    """The request is JSON, but its fields are not what they must be."""

    status, kind, title = 422, "invalid", "Invalid fields"

    def __init__(self, fields: Sequence[FieldError]) -> None:
        names = ", ".join(dict.fromkeys(f.field for f in fields))
        super().__init__(f"Invalid fields: {names}.", fields=fields)

    @classmethod
    def field(cls, field: str, detail: str) -> InvalidError:
        """Return the error of one field."""
        return cls((FieldError(field, detail),))


class TooManyError(CalibdbError):
    """The plan's calls of this hour are used up, or this contributor's share of them."""

    status, kind, title = 429, "quota", "Quota used up"

    def __init__(
        self,
        retry_after: int,
        detail: str = "The plan allows no more calls this hour; retry after the time in Retry-After.",
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(detail, headers={"Retry-After": str(max(1, retry_after)), **(headers or {})})


class UnavailableError(CalibdbError):
    """Storage or a function is temporarily unavailable; retry."""

    status, kind, title = 503, "unavailable", "Try again"

    def __init__(self, detail: str) -> None:
        super().__init__(detail, headers={"Retry-After": "1"})


class UnhealthyError(CalibdbError):
    """Some part of the service does not work; `parts` says which."""

    status, kind, title = 503, "unhealthy", "Not everything works"


class DeniedReadError(UnavailableError):
    """S3 denied an object that is there, or may be there: nothing may be concluded from its absence."""
