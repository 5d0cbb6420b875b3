"""Health of the service: its parts, and its canary's last run."""

from typing import Literal

from pydantic import Field

from calibdb.schema.fields import Open, UnixTime
from calibdb.schema.problem import Problem
from calibdb.schema.session import Health

PartName = Literal["table", "bucket", "solver", "edge"]
CanaryStep = Literal["lookup", "open", "pose", "view", "result"]


class PartHealth(Open):
    """One part, checked within a time of its own."""

    part: PartName = Field(description="Name of the part.")
    ok: bool = Field(description="True if it works.")
    latency_ms: float | None = Field(description="Time of the check; null: it failed, or took longer.")
    limit_ms: int = Field(description="Time that the check had.")


class CanaryRun(Open):
    """Last lookup and capture that the service made of itself, if it makes any."""

    ok: bool = Field(description="True if it works.")
    at: UnixTime
    took_ms: int = Field(description="Duration, ms.")
    failed_at: CanaryStep | None = Field(None, description="The step that failed; null: none.")


class CheckedParts(Open):
    """Parts of the service, and its canary."""

    checked_at: int = Field(description="Unix seconds. An answer is remembered for ten seconds.")
    parts: tuple[PartHealth, ...] = Field(description="Each part of the service.")
    canary: CanaryRun | None = Field(description="Null: there is none, or it has not run for two hours.")


class DeepHealth(Health, CheckedParts):
    """Every part works."""


class HealthProblem(Problem, CheckedParts):
    """Some part does not work, or the canary failed."""
