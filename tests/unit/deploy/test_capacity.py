"""The model on paper of a million captures per day, against the template, the plans and the quotas."""

import pytest

from infra.deploy import processor
from infra.deploy.account_check import RESERVED
from tests.bench import capacity
from tests.bench.capacity import LARGE, LARGE_ACCOUNT_CONCURRENCY, defaults, limits


def test_plan_of_the_pages_is_the_first_limit_by_default() -> None:
    found = limits(defaults())
    assert found[0].name == "plan page, sessions per hour"
    assert found[0].use == pytest.approx(125.0)
    # The largest day that the defaults serve
    daily = capacity.DAILY_CAPTURES / found[0].use
    assert daily == pytest.approx(8_000)
    assert limits(defaults(), captures=daily)[0].use == pytest.approx(1.0)
    exceeded = {limit.name.partition(",")[0].partition(" of ")[0] for limit in found if limit.use > 1}
    assert exceeded == {"plan page", "RequestRate", "ComputeRate", *(set(LARGE) & set(RESERVED))}


def test_parameters_for_a_million_captures_suffice() -> None:
    values = defaults()
    assert LARGE.keys() <= values.keys()
    found = limits({**values, **LARGE}, LARGE_ACCOUNT_CONCURRENCY)
    assert [limit for limit in found if limit.use > 1] == []
    assert found[0].name == "RefitConcurrency, instances"
    assert found[0].use > 0.8
    assert float(LARGE["ComputeRate"]) < float(LARGE["RequestRate"])
    # Each is needed.
    for name in LARGE.keys() - {"RequestBurst"}:
        without = limits({**values, **LARGE, name: values[name]}, LARGE_ACCOUNT_CONCURRENCY)
        assert without[0].use > 1, name


def test_counters_of_one_key_would_not_suffice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(capacity, "SHARDS", 1)
    found = limits({**defaults(), **LARGE}, LARGE_ACCOUNT_CONCURRENCY)
    assert [limit.name for limit in found if limit.use > 1] == [
        "DynamoDB, writes/s of one key of the page's token"
    ]


def test_processor_is_compared_with_the_reference() -> None:
    assert processor.factor(processor.REFERENCE_S) == pytest.approx(1 / processor.SHARE_OF_A_CORE)
    default = float(defaults()["ProcessorFactor"])
    assert processor.factor(processor.REFERENCE_S) < default
