"""Populations: fields of view of the models of one kind, or of one maker and kind."""

import math
import statistics
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from calibdb.estimate.angles import Size
from calibdb.estimate.crops import transfer
from calibdb.estimate.facts import Fact

# Kinds of facts for kinds of devices that have none of their own.
_POOLS = {
    "webcam": ("usb_webcam", "laptop_builtin"),
    "virtual": ("usb_webcam", "laptop_builtin"),
    "tablet_front": ("tablet_front", "phone_front"),
}
_CAMERAS = {"phone_ultrawide": "ultrawide", "phone_tele": "tele", "phone_rear": "wide", "tablet_rear": "wide"}
_LENS_KINDS = ("phone_ultrawide", "phone_tele")
_MIN_FAMILY = 4
_POOLED_FREEDOM = 32  # weight of other makers, models
_MIN_QUANTILE_COUNT = 19  # models from which the 5th and 95th percentiles are inside the sample
QUANTILE = 1.645  # of the normal distribution, 95 %


@dataclass(frozen=True)
class Population:
    """Distribution of `log_tan` of a model: median, 5th and 95th percentile."""

    n: int
    median: float
    low: float
    high: float

    @property
    def sigma(self) -> float:
        """Standard deviation of a normal distribution with this interval."""
        return (self.high - self.low) / (2 * QUANTILE)


def members(facts: Iterable[Fact], kind: str) -> list[Fact]:
    """Facts about a kind of device."""
    kinds = ("phone_rear",) if kind in _LENS_KINDS else _POOLS.get(kind, (kind,))
    camera = _CAMERAS.get(kind)
    return [fact for fact in facts if fact.kind in kinds and (camera is None or fact.camera == camera)]


def by_model(facts: Iterable[Fact], size: Size) -> dict[tuple[str, str], float]:
    """Median value of each model at the aspect of `size`, by facts of this aspect if any."""
    models: dict[tuple[str, str], list[tuple[float, float]]] = defaultdict(list)
    for fact in facts:
        change, sigma = transfer(fact.kind, fact.size, size)
        models[fact.maker, fact.model].append((round(sigma, 2), fact.log_tan + change))
    values = {}
    for model, entries in models.items():
        best = min(sigma for sigma, _ in entries)
        values[model] = statistics.median(value for sigma, value in entries if sigma == best)
    return values


def population(values: Sequence[float]) -> Population:
    """Predict the next model from those known, at least two."""
    ordered, n = sorted(values), len(values)
    if n >= _MIN_QUANTILE_COUNT:
        low, *_, high = statistics.quantiles(ordered, n=20)  # another member is below them with p = i / 20
        return Population(n, statistics.median(ordered), low, high)
    mean, sd = statistics.mean(ordered), statistics.stdev(ordered)
    reach = _student_t(n - 1) * sd * math.sqrt(1 + 1 / n)
    return Population(n, mean, mean - reach, mean + reach)


def family(values: Mapping[tuple[str, str], float], maker: str) -> Population | None:
    """Predict the next model of a maker from the models of all makers, keyed by maker and model.

    Random effects: makers deviate from the kind's mean, and models from their maker's, by a pooled deviation.
    None if too few models are known.
    """
    makers: dict[str, list[float]] = defaultdict(list)
    for (each, _), value in values.items():
        makers[each].append(value)
    own = makers.get(maker, [])
    several = [group for group in makers.values() if len(group) > 1]
    freedom = sum(len(group) - 1 for group in several)
    if len(own) < _MIN_FAMILY or freedom < _MIN_FAMILY:
        return None
    pooled = sum(statistics.variance(group) * (len(group) - 1) for group in several) / freedom
    squares = statistics.variance(own) * (len(own) - 1) + _POOLED_FREEDOM * pooled
    within = squares / (len(own) - 1 + _POOLED_FREEDOM)
    total = statistics.variance(values.values())
    between = max(total - within, 0.1 * within)
    precision = len(own) / within + 1 / between
    mean = (len(own) / within * statistics.mean(own) + statistics.mean(values.values()) / between) / precision
    reach = _student_t(freedom) * math.sqrt(within + 1 / precision)
    return Population(len(own), mean, mean - reach, mean + reach)


def _student_t(freedom: int) -> float:
    """95 % quantile of the t distribution, within 2 % from two degrees of freedom (Cornish-Fisher)."""
    z = QUANTILE
    g1 = (z**3 + z) / 4
    g2 = (5 * z**5 + 16 * z**3 + 3 * z) / 96
    g3 = (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384
    return z + g1 / freedom + g2 / freedom**2 + g3 / freedom**3
