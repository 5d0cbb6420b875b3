"""What is asked of AWS, at list prices: `make cost` says what for."""

from collections.abc import Iterator

import yaml

from infra.cost import MOST, PRICES, measured, price, scale
from tests.bench.table import Row


def rows() -> Iterator[Row]:
    prices = yaml.safe_load(PRICES.read_text())
    for name, use in measured().items():
        total = scale(name, use) * sum(price(use, prices).values())
        yield Row(f"price of {name}", total, MOST[name], "USD", "list prices")
