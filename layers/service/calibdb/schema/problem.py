"""Problem details: RFC 9457, `application/problem+json`."""

from pydantic import Field

from calibdb.schema.estimate import Estimate
from calibdb.schema.fields import Detail, Open
from calibdb.schema.lookup import ESTIMATE_TEXT, GuidanceUrl, MissReason


class FieldProblem(Open):
    """One field of the request, its path joined by dots, and what is wrong with it."""

    field: str = Field(description="Path of the field.")
    detail: Detail


class Problem(Open):
    """Problem details (RFC 9457). `errors` is there on 422."""

    type: str = Field(description="Address of a page that explains what to do.")
    title: str = Field(description="Kind of problem, for people.")
    status: int = Field(description="HTTP status.")
    detail: Detail
    errors: tuple[FieldProblem, ...] = Field(
        (), description="The fields that are wrong, each with the reason."
    )


class LookupProblem(Problem):
    """Nothing reliable is known, and where to go instead (`redirect=false`)."""

    guidance_url: GuidanceUrl
    reason: MissReason
    estimate: Estimate | None = Field(None, description=ESTIMATE_TEXT)
