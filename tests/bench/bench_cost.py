"""Costs of a lookup and of a calibration at AWS list prices."""

from collections.abc import Iterator

import yaml

from infra.measure.cost import MAX_USD, PRICES, measure, price, scale_factor
from tests.bench.table import Row


def rows() -> Iterator[Row]:
    prices = yaml.safe_load(PRICES.read_text())
    for name, use in measure().items():
        total = scale_factor(name, use) * sum(price(use, prices).values())
        yield Row(f"price of {name}", total, MAX_USD[name], "USD", "list prices")
