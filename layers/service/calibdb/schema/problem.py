"""Errors as they are answered: RFC 9457 `application/problem+json`."""

from __future__ import annotations

from pydantic import Field

from calibdb.schema.estimate import Estimate
from calibdb.schema.fields import Open
from calibdb.schema.lookup import ESTIMATE_TEXT, Reason


class FieldProblem(Open):
    """One field of the request, its path joined by dots, and what is wrong with it."""

    field: str
    detail: str


class Problem(Open):
    """Problem details (RFC 9457). `errors` is there on 422."""

    type: str
    title: str
    status: int
    detail: str
    errors: tuple[FieldProblem, ...] = ()


class LookupProblem(Problem):
    """Nothing reliable is known, and where to go instead (`redirect=false`)."""

    guidance_url: str
    reason: Reason
    estimate: Estimate | None = Field(None, description=ESTIMATE_TEXT)
