"""Limits of a deployment under a number of captures per day, on paper: `make bench DOCS=capacity`.

Demand follows from a day of captures, capacity from the template's parameters, the plans and AWS's default
quotas. Nothing is measured; durations are assumed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from calibdb.access.plans import multiplied
from calibdb.settings import parse_plan_factors
from calibdb.store.quotas import SHARDS
from infra.deploy.account_check import RESERVED
from infra.deploy.package import ROOT
from infra.deploy.template import parse

DAILY_CAPTURES = 1_000_000
PEAK = 3.0  # busiest hour / mean hour
VIEWS, POSES = 6, 12  # of a capture; each pose as numbers and as an image
_OTHER_REQUESTS = 3  # token and session at its start, its end
# s for which a request occupies an instance, storage included, on Lambda's processor. Assumed.
_SUBMIT_S, _POSE_S, _REFIT_S = 0.7, 0.1, 5.0
_COUNTERS = 2  # writes of a counted call: of the token and of its user
# Default quotas: API Gateway, requests/s; DynamoDB, writes/s of a partition key; Lambda, instances
_GATEWAY, _PARTITION = 10_000, 1_000
ACCOUNT_CONCURRENCY = 1_000
#: parameters, and concurrent executions of the account, for `DAILY_CAPTURES`
LARGE = {
    "PlanFactors": "page=150",
    "RequestRate": "1500",
    "RequestBurst": "3000",
    "ComputeRate": "1000",
    "SubmitConcurrency": "300",
    "PoseConcurrency": "100",
    "RefitConcurrency": "200",
}
LARGE_ACCOUNT_CONCURRENCY = 3_000


@dataclass(frozen=True)
class Limit:
    """A limit, what the captures demand of it at the peak, and what there is."""

    name: str
    demand: float
    capacity: float

    @property
    def use(self) -> float:
        """Demand / capacity; above 1 requests are refused or wait."""
        return self.demand / self.capacity


def defaults() -> dict[str, str]:
    parameters = parse(ROOT / "template.yaml")["Parameters"]
    return {name: str(parameter.get("Default", "")) for name, parameter in parameters.items()}


def limits(
    values: Mapping[str, str], account: int = ACCOUNT_CONCURRENCY, captures: float = DAILY_CAPTURES
) -> list[Limit]:
    """Limits under so many `captures` per day of the site's pages, the first one to be reached first.

    `values`: parameters of the template. `account`: its concurrent executions.
    """
    return sorted(_limits(values, account, captures), key=lambda limit: -limit.use)


def _limits(values: Mapping[str, str], account: int, captures: float) -> Iterator[Limit]:
    hourly, rate = captures / 24 * PEAK, captures / 86_400 * PEAK
    plan = multiplied(parse_plan_factors(values["PlanFactors"]))["page"].together
    for kind, each in (("sessions", 1), ("views", VIEWS), ("poses", 2 * POSES + 2)):
        limit = getattr(plan, kind)
        yield Limit(f"plan page, {kind} per hour", hourly * each, limit)
    per_capture = VIEWS + 2 * POSES + _OTHER_REQUESTS
    yield Limit("RequestRate, requests/s", rate * per_capture, float(values["RequestRate"]))
    yield Limit("API Gateway's quota, requests/s", rate * per_capture, _GATEWAY)
    yield Limit("ComputeRate of GET /v1/session/pose, 1/s", rate * 2 * POSES, float(values["ComputeRate"]))
    yield Limit("ComputeRate of POST /v1/session/views, 1/s", rate * VIEWS, float(values["ComputeRate"]))
    busy = {
        "SubmitConcurrency": rate * VIEWS * _SUBMIT_S,
        "PoseConcurrency": rate * 2 * POSES * _POSE_S,
        "RefitConcurrency": rate * _REFIT_S,
    }
    for name, instances in busy.items():
        yield Limit(f"{name}, instances", instances, float(values[name]) or account)
    reserved = sum(functions * float(values[name]) for name, functions in RESERVED.items())
    yield Limit("Lambda's quota, instances", reserved + 100, account)
    counted = rate * (per_capture - 1) * _COUNTERS
    yield Limit("DynamoDB, writes/s of one key of the page's token", counted / SHARDS, _PARTITION)


def main() -> None:
    print(f"{DAILY_CAPTURES:,} captures per day, {PEAK:.0f} times the mean at the peak; demand / capacity:")
    show(defaults(), ACCOUNT_CONCURRENCY)
    print(f"with {' '.join(f'{n}={v}' for n, v in LARGE.items())}, {LARGE_ACCOUNT_CONCURRENCY} instances:")
    show({**defaults(), **LARGE}, LARGE_ACCOUNT_CONCURRENCY)


def show(values: Mapping[str, str], account: int) -> None:
    for limit in limits(values, account):
        print(f"  {limit.use:7.2f}  {limit.name:52} {limit.demand:10,.0f} of {limit.capacity:10,.0f}")


if __name__ == "__main__":
    main()
