"""A simulated month of lookups, answered at the edge wherever it can: hits, fetches, functions, price.

Cameras are asked for by Zipf's law, each under many labels and platforms, and these by Zipf's law again.
Every edge location keeps an answer for five minutes. An alias is answered there from its n-th lookup on, n
being the contributors that a reliable consensus needs; the lookups before go to the functions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibdb.settings import Thresholds

CAMERAS, ALIASES, LOOKUPS = 2_000, 40, 1_000_000
TTL_S = 300.0  # seconds for which a location keeps an answer: s-maxage
MONTH_S = 730 * 3600.0
#: USD for the million lookups of a month in which the aliases are known
MAX_MONTH_USD = 1.50
_SIMULATION_SEED = 17
_GB = 1e9


@dataclass(frozen=True)
class Month:
    """Lookups of a month: all, those that a location had the answer to, those by functions, new aliases."""

    lookups: int
    hits: int
    by_function: int
    new_aliases: int

    @property
    def fetches(self) -> int:
        """Requests of the edge to the bucket, those for answers that are not there included."""
        return self.lookups - self.hits


def simulate(locations: int, *, known: bool, lookups: int = LOOKUPS, seed: int = _SIMULATION_SEED) -> Month:
    """Simulate a month.

    Parameters
    ----------
    locations
        Edge locations, which share nothing and have users by Zipf's law.
    known
        Whether every alias was written down in earlier months.
    lookups
        Spread evenly over the month.
    seed
        Of the random numbers.
    """
    rng = np.random.default_rng(seed)
    cameras, aliases, places = (_zipf(rng, n, lookups) for n in (CAMERAS, ALIASES, locations))
    times = np.sort(rng.uniform(0, MONTH_S, lookups))
    needed = 0 if known else Thresholds().min_contributors
    asked = np.zeros(CAMERAS * ALIASES, dtype=np.int64)
    kept_until: dict[int, float] = {}
    hits = by_function = 0
    for name, place, now in zip((cameras * ALIASES + aliases).tolist(), places.tolist(), times, strict=True):
        asked[name] += 1
        if asked[name] <= needed:
            by_function += 1
            continue
        key = name * locations + place
        if kept_until.get(key, -1.0) >= now:
            hits += 1
        else:
            kept_until[key] = now + TTL_S
    new = 0 if known else int((asked >= needed).sum())
    return Month(lookups, hits, by_function, new)


@dataclass(frozen=True)
class MeasuredCosts:
    """Measured prices and sizes that a month is made of.

    Attributes
    ----------
    by_function_usd
        Of a lookup that a function answers, CloudFront's part included.
    alias_usd
        Of writing down an alias.
    sent
        Bytes of an answer's body. CloudFront compresses none of less than a thousand.
    """

    by_function_usd: float
    alias_usd: float
    sent: float


def price_month(month: Month, measured: MeasuredCosts, prices: Mapping[str, Any]) -> dict[str, float]:
    """Price a month; USD by kind of cost. `prices`: list prices and assumptions."""
    size = measured.sent + prices["assumed"]["edge_header_bytes"]
    return {
        "edge requests": month.lookups * prices["cloudfront_request"],
        "edge transfer": month.lookups * size / _GB * prices["cloudfront_gb"],
        "fetches from the bucket": month.fetches * prices["s3_get"],
        "lookups by functions": month.by_function * measured.by_function_usd,
        "new aliases": month.new_aliases * measured.alias_usd,
    }


def report(measured: MeasuredCosts, prices: Mapping[str, Any]) -> Iterator[str]:
    """Yield the first month of a deployment and a later one, line by line."""
    locations = prices["assumed"]["edge_locations"]
    alone = LOOKUPS * measured.by_function_usd
    yield f"simulated: {LOOKUPS:,} lookups, {CAMERAS:,} cameras of {ALIASES} aliases, {locations} locations"
    for what, known in (("the first month", False), ("a later month", True)):
        month = simulate(locations, known=known)
        parts = price_month(month, measured, prices)
        bound = f", at most {MAX_MONTH_USD:.2f}" if known else ""
        yield f"{what}: {sum(parts.values()):.2f} USD{bound}; {alone:.2f} by functions alone"
        shares = (
            f"{month.hits / month.lookups:.1%} cached",
            f"{month.by_function / month.lookups:.1%} by functions",
        )
        yield f"  {', '.join(shares)}"
        for part, usd in parts.items():
            yield f"  {part:28} {usd:.6f}"


def later_month_usd(measured: MeasuredCosts, prices: Mapping[str, Any]) -> float:
    """Compute the price of a month in which every alias is known, USD."""
    month = simulate(prices["assumed"]["edge_locations"], known=True)
    return sum(price_month(month, measured, prices).values())


def _zipf(rng: np.random.Generator, count: int, size: int) -> NDArray[np.int64]:
    weights = 1.0 / np.arange(1, count + 1)
    return rng.choice(count, size, p=weights / weights.sum()).astype(np.int64)
