"""Costs of a lookup and of a calibration at AWS list prices."""

from collections.abc import Iterator

import yaml

from tests.bench.cost import (
    LOOKUPS,
    MAX_EDGE_USD,
    MAX_FIXED_USD,
    MAX_USD,
    at_edge,
    measure,
    mixed_at_edge,
    price_of,
)
from tests.bench.table import Row
from tests.bench.usage import PRICES, fixed_costs


def rows() -> Iterator[Row]:
    prices = yaml.safe_load(PRICES.read_text())
    uses = measure()
    for name, use in uses.items():
        total = sum(price_of(name, use, prices).values())
        yield Row(f"price of {name}", total, MAX_USD[name], "USD", "list prices")
    edge = mixed_at_edge(*at_edge(uses[LOOKUPS], prices))
    yield Row("price of a million lookups, 80 % cached", edge, MAX_EDGE_USD, "USD", "list prices")
    fixed = sum(fixed_costs(prices).values())
    yield Row("price of a month without requests", fixed, MAX_FIXED_USD, "USD", "list prices")
