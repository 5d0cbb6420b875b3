"""Price of calls to AWS, by calls and sizes measured here and prices written down."""

import re
from dataclasses import replace

import pytest
import yaml

from infra.deploy.template import parse
from tests.bench.cost import MAX_EDGE_USD, MAX_FIXED_USD, MAX_USD, at_edge, measure, mixed_at_edge, price_of
from tests.bench.usage import PRICES, Usage, firewall, fixed_costs, price, price_at_edge
from tests.helpers.data import ROOT
from tests.helpers.service.storage_calls import lasting_tokens

LIST = yaml.safe_load(PRICES.read_text())
MAX_COMPUTE_USD = {"a million lookups": 0.1, "a finished calibration": 0.0001}
"""Part of the price that the processor's time may take: `make bench` measures it, on an idle machine."""


def test_a_lookup_and_a_calibration_are_affordable() -> None:
    with lasting_tokens():
        uses = measure(lookups=5, pooled=1)
    lookup, calibration = uses["a million lookups"], uses["a finished calibration"]
    assert lookup.requests == lookup.invocations == 5
    # One Query each, nothing written, nothing else asked.
    assert [service for service, _ in lookup.waits] == ["dynamodb"] * 5
    assert (lookup.writes, lookup.puts, lookup.gets) == (0, 0, 0)
    assert MAX_USD["a million lookups"] == 2.0
    for name, most in MAX_COMPUTE_USD.items():
        assert uses[name].gb_seconds > 0
        parts = price_of(name, replace(uses[name], gb_seconds=0.0), LIST)
        assert sum(parts.values()) <= MAX_USD[name] - most
    parts = price_of("a million lookups", lookup, LIST)
    # One in twenty asks first whether it may; each of these is at least a request.
    assert parts["preflights"] >= 0.05
    edge = at_edge(replace(lookup, gb_seconds=0.0), LIST)
    assert mixed_at_edge(*edge) <= MAX_EDGE_USD - 0.2 * MAX_COMPUTE_USD["a million lookups"]
    assert calibration.kept > 1000
    assert calibration.puts >= 3


def test_fixed_costs_are_bounded_and_the_budget_is_above_them() -> None:
    costs = fixed_costs(LIST)
    total = sum(costs.values())
    assert 5 < total <= MAX_FIXED_USD == 12.0
    budget = parse(ROOT / "template.yaml")["Parameters"]["MonthlyBudget"]["Default"]
    with_firewall = total + firewall(LIST)
    assert with_firewall <= MAX_FIXED_USD + 6.0
    assert 0.8 * budget > 2 * with_firewall  # it rings at 80 %
    assert {"dashboard", "ServerErrorAlarm", "index and its recovery"} <= costs.keys()


def test_every_price_has_a_source_and_a_date() -> None:
    prices = dict(LIST)
    sources = prices.pop("sources")
    assert re.fullmatch(r"20\d\d-\d\d", str(sources.pop("month")))
    assert all(re.fullmatch(r"https://aws\.amazon\.com/[\w/-]+/", page) for page in sources)
    named = [name for names in sources.values() for name in names]
    assert sorted(named) == sorted(prices.keys() - {"assumed", "not_in_it"})


def test_every_use_has_its_price() -> None:
    assert sum(price(Usage(), LIST).values()) == 0
    for use, usd in (
        (Usage(invocations=1_000_000), 0.20),
        (Usage(gb_seconds=1000.0), 0.0133334),
        (Usage(reads=1e6, writes=1e6), 0.75),
        (Usage(puts=1000, gets=1000), 0.0054),
        (Usage(kept=10**9), 0.023 * 36),
        (Usage(sent=10**9), 0.09),
        (Usage(memory=1000.0), 0.005 * 1.0 * 1000 * 13.3334e-6),
        (Usage(solver_memory=1000.0), 0.005 * 5.0 * 1000 * 13.3334e-6),
        (Usage(waits=[("dynamodb", 0.5)] * 1000), 0.005 * 500 * 13.3334e-6),
    ):
        assert sum(price(use, LIST).values()) == pytest.approx(usd)
    parts = price(Usage(requests=10**6, sent=10**9), LIST)
    asked, known = price_at_edge(parts, 1e9, LIST)
    assert known == pytest.approx(1.0 + 0.085), "CloudFront is paid by requests and bytes"
    assert asked == pytest.approx(sum(parts.values()) + known - 0.09)
