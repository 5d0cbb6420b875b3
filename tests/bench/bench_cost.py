"""Costs of a lookup and of a calibration at AWS list prices."""

from collections.abc import Iterator

import yaml

from infra.measure.cost import MAX_FIXED_USD, MAX_USD, measure, price_of
from infra.measure.fixed_costs import fixed_costs
from infra.measure.usage import PRICES
from tests.bench.table import Row


def rows() -> Iterator[Row]:
    prices = yaml.safe_load(PRICES.read_text())
    for name, use in measure().items():
        total = sum(price_of(name, use, prices).values())
        yield Row(f"price of {name}", total, MAX_USD[name], "USD", "list prices")
    fixed = sum(cost.usd for cost in fixed_costs(prices))
    yield Row("price of a month without requests", fixed, MAX_FIXED_USD, "USD", "list prices")
