"""Costs of a lookup and of a calibration at AWS list prices."""

from collections.abc import Iterator

import yaml

from tests.bench import edge_month
from tests.bench.cost import LOOKUPS, MAX_FIXED_USD, MAX_USD, at_edge, measure, price_of
from tests.bench.table import Row
from tests.bench.usage import PRICES, fixed_costs


def rows() -> Iterator[Row]:
    prices = yaml.safe_load(PRICES.read_text())
    uses = measure()
    for name, use in uses.items():
        total = sum(price_of(name, use, prices).values())
        yield Row(f"price of {name}", total, MAX_USD[name], "USD", "list prices")
    edge = edge_month.price(*at_edge(uses[LOOKUPS], prices))
    yield Row("price of a million lookups, 80 % cached", edge, edge_month.MAX_EDGE_USD, "USD", "list prices")
    fixed = sum(fixed_costs(prices).values())
    yield Row("price of a month without requests", fixed, MAX_FIXED_USD, "USD", "list prices")
