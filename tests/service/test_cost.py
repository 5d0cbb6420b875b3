"""Price of calls to AWS, by calls and sizes measured here and prices written down."""

import pytest
import yaml

from infra.measure.cost import MAX_USD, PRICES, Usage, measure, price, price_at_edge, read_units, write_units
from tests.helpers.service.storage_calls import lasting_tokens


def test_a_lookup_and_a_calibration_are_affordable() -> None:
    prices = yaml.safe_load(PRICES.read_text())
    with lasting_tokens():
        uses = measure(lookups=100)
    lookup, calibration = uses["a million lookups"], uses["a finished calibration"]
    assert lookup.requests == lookup.invocations == 100
    # One Query each, nothing written, nothing else asked.
    assert [service for service, _ in lookup.waits] == ["dynamodb"] * 100
    assert (lookup.writes, lookup.puts, lookup.gets) == (0, 0, 0)
    assert 1e4 * sum(price(lookup, prices).values()) <= MAX_USD["a million lookups"]
    assert calibration.kept > 1000
    assert calibration.puts >= 3
    assert sum(price(calibration, prices).values()) <= MAX_USD["a finished calibration"]


def test_units_as_dynamodb_counts_them() -> None:
    assert [read_units(n, consistent=False) for n in (0, 4096, 4097)] == [0.5, 0.5, 1.0]
    assert read_units(4097, consistent=True) == 2.0
    assert [write_units(n, together=False) for n in (0, 1024, 1025)] == [1, 1, 2]
    assert write_units(1025, together=True) == 4


def test_every_use_has_its_price() -> None:
    prices = yaml.safe_load(PRICES.read_text())
    assert sum(price(Usage(), prices).values()) == 0
    for use, usd in (
        (Usage(invocations=1_000_000), 0.20),
        (Usage(gb_seconds=1000.0), 0.0133334),
        (Usage(reads=1e6, writes=1e6), 0.75),
        (Usage(puts=1000, gets=1000), 0.0054),
        (Usage(kept=10**9), 0.023 * 36),
        (Usage(sent=10**9), 0.09),
        (Usage(memory=1000.0), 0.005 * 1.0 * 1000 * 13.3334e-6),
        (Usage(waits=[("dynamodb", 0.5)] * 1000), 0.005 * 500 * 13.3334e-6),
    ):
        assert sum(price(use, prices).values()) == pytest.approx(usd)


def test_cloudfront_is_paid_by_requests_and_bytes() -> None:
    prices = yaml.safe_load(PRICES.read_text())
    parts = price(Usage(requests=10**6, sent=10**9), prices)
    asked, known = price_at_edge(parts, 1e9, prices)
    assert known == pytest.approx(1.0 + 0.085)
    assert asked == pytest.approx(sum(parts.values()) + known - 0.09)
