"""Hit rate and price of lookups at the edge, for a number of lookups per month.

Lookups are a Poisson process. Cameras are asked for by Zipf's law, each under many labels and platforms, and
these by Zipf's law again. Edge locations share nothing and keep a response for five minutes: an address that
is asked for at the rate r there hits with the probability r T / (1 + r T).
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

CAMERAS, ALIASES = 2_000, 40
TTL_S = 300.0  # s for which a location keeps a response: s-maxage
MONTH_S = 730 * 3600.0
HIT_RATE = 0.8
"""Hit rate for which the price of a million lookups is stated."""
MAX_EDGE_USD = 1.50
"""USD for a million lookups at that hit rate."""


def hit_rate(lookups: float, locations: int) -> float:
    """Share of so many lookups per month that the edge has cached."""
    share = np.multiply.outer(np.multiply.outer(_zipf(CAMERAS), _zipf(ALIASES)), _zipf(locations))
    expected = share * (lookups / MONTH_S * TTL_S)
    return float((share * expected / (1 + expected)).sum())


def lookups_for(rate: float, locations: int) -> float:
    """Lookups per month from which on the hit rate is at least `rate`."""
    low, high = 1.0, 1e12
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if hit_rate(middle, locations) < rate else (low, middle)
    return high


def price(forwarded_price: float, cached: float, rate: float = HIT_RATE) -> float:
    return (1 - rate) * forwarded_price + rate * cached


def report(forwarded_price: float, cached: float, locations: int) -> Iterator[str]:
    usd = price(forwarded_price, cached)
    yield f"a million lookups at the edge, {HIT_RATE:.0%} cached: {usd:.2f} USD, at most {MAX_EDGE_USD:.2f}"
    yield f"  modelled: {CAMERAS:,} cameras of {ALIASES} aliases by Zipf's law, {locations} locations:"
    for lookups in (1e6, 1e7, 1e8, 1e9):
        rate = hit_rate(lookups, locations)
        usd = price(forwarded_price, cached, rate)
        yield f"  {lookups:>13,.0f} lookups per month: {rate:5.1%} cached, {usd:.2f} USD per million"
    yield f"  {HIT_RATE:.0%} from {lookups_for(HIT_RATE, locations):,.0f} lookups per month"


def _zipf(count: int) -> NDArray[np.float64]:
    weights: NDArray[np.float64] = 1.0 / np.arange(1, count + 1)
    weights /= weights.sum()
    return weights
