"""Errors of the client: one tree. Each says what to do, and has the command's exit status."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .recording import Recording


class CalibDBError(Exception):
    """Base of every error that the client raises on purpose; `recording` has the views captured before it."""

    exit_status = 1
    recording: Recording | None = None


class UsageError(CalibDBError, ValueError):
    """A value that cannot be used; the text says which would do."""

    exit_status = 2


class MissingPackageError(CalibDBError, ImportError):
    """A package that is needed for this, and not for the rest, is not installed."""

    exit_status = 2


class ServiceUnavailableError(CalibDBError):
    """The service was not reached, was too slow, or failed, also when it was asked again."""

    exit_status = 3


class CameraError(CalibDBError):
    """A camera of this machine cannot be used, or not be distinguished from another."""

    exit_status = 6


class CaptureError(CalibDBError):
    """Pictures that do not suffice for a calibration."""

    exit_status = 7


class MirroredError(CaptureError):
    """The pictures are mirrored, and can be turned back."""

    def __init__(self) -> None:
        super().__init__(
            "the pictures are mirrored: pass --mirrored to turn them back, or turn mirroring off in the "
            "camera's software"
        )


@dataclass(frozen=True)
class FieldProblem:
    """One field of a request that the service refused: its path, joined by dots, and the reason."""

    field: str
    detail: str


class ProblemError(CalibDBError):
    """An error that the service answered (RFC 9457, problem details), with all its members.

    `kind` is what follows the last `#` or `/` of `type`; `retry_after`: seconds after which the same request
    may succeed; None if the service names none.
    """

    exit_status = 2

    def __init__(
        self,
        status: int,
        title: str,
        detail: str,
        *,
        type: str = "about:blank",  # noqa: A002 - the standard's name
        errors: Sequence[FieldProblem] = (),
        retry_after: float | None = None,
        members: Mapping[str, Any] | None = None,
    ) -> None:
        self.status, self.title, self.detail, self.type = status, title, detail, type
        self.kind = type.replace("#", "/").rstrip("/").rpartition("/")[2]
        self.errors = tuple(errors)
        self.retry_after = retry_after
        self.members = dict(members or {})
        fields = "; ".join(f"{each.field}: {each.detail}" for each in self.errors)
        super().__init__(" ".join(part for part in (detail or title, fields) if part))


class CredentialError(ProblemError):
    """The service does not take the token, or the session has ended (401, 403)."""

    exit_status = 4


class NotFoundError(ProblemError):
    """The service has nothing under this name (404), or withdrew it (410)."""

    exit_status = 1


class QuotaError(ProblemError):
    """The calls of the token's plan are used up for now (429)."""

    exit_status = 5


class ConflictError(ProblemError):
    """The request conflicts with the state of the service (409)."""
