"""Errors of the service: one tree, each error with its RFC 9457 problem document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pydantic import JsonValue

MAX_FIELD_ERRORS = 20  # in one response
PROBLEMS = "/docs/problems/#"  # page of the site


@dataclass(frozen=True)
class FieldError:
    """Invalid field of a request; `field`: its path, joined by dots."""

    field: str
    detail: str


class CalibdbError(Exception):
    """Base of all errors that a caller receives.

    `detail` contains nothing that the caller sent, except names of fields. `kind` is the last part of the
    problem's type if one class stands for several, `extensions` are members of the document (RFC 9457, 3.2).
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
        """Problem document, its `type` relative to the site."""
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
    """The credential is unknown, expired, or not from this origin."""

    status, kind, title = 403, "forbidden", "Credential refused"


class NotFoundError(CalibdbError):
    """The resource does not exist."""

    status, kind, title = 404, "not-found", "Not found"


class NotAcceptableError(CalibdbError):
    """The caller accepts none of the media types."""

    status, kind, title = 406, "not-acceptable", "Not acceptable"


class ConflictError(CalibdbError):
    """The request contradicts the current state."""

    status, kind, title = 409, "conflict", "Conflict"


class GoneError(CalibdbError):
    """The calibration was withdrawn."""

    status, kind, title = 410, "gone", "Withdrawn"


class TooLargeError(CalibdbError):
    """The body is too large."""

    status, kind, title = 413, "too-large", "Body too large"


class UnsupportedMediaTypeError(CalibdbError):
    """The body is not declared as JSON."""

    status, kind, title = 415, "unsupported-media-type", "Not declared as JSON"


class InvalidError(CalibdbError):
    """Fields of the request are invalid."""

    status, kind, title = 422, "invalid", "Invalid fields"

    def __init__(self, fields: Sequence[FieldError]) -> None:
        names = ", ".join(dict.fromkeys(f.field for f in fields))
        super().__init__(f"Invalid fields: {names}.", fields=fields)

    @classmethod
    def field(cls, field: str, detail: str) -> InvalidError:
        """Error of one field."""
        return cls((FieldError(field, detail),))


class TooManyError(CalibdbError):
    """The plan's calls of this hour, or a share of them, are used up."""

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
    """Some part of the service does not work."""

    status, kind, title = 503, "unhealthy", "Not everything works"


class DeniedReadError(UnavailableError):
    """S3 denied an object, which may exist."""
