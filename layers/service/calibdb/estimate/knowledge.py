"""Knowledge about cameras from the table of facts."""

import functools
import math
from collections.abc import Iterable

from calibdb.estimate.angles import Size
from calibdb.estimate.crops import aspect_log
from calibdb.estimate.device import Device
from calibdb.estimate.evidence import Evidence
from calibdb.estimate.facts import Fact, all_facts
from calibdb.estimate.population import Population, by_model, family, members, population
from calibdb.estimate.published import facts_about, published

_MIN_POPULATION = 3
_FALLBACK = "webcam"


class Knowledge:
    """Facts of a table, with their populations. Thread-safe."""

    def __init__(self, facts: Iterable[Fact]) -> None:
        self.facts = tuple(facts)
        self._distribution = functools.lru_cache(maxsize=256)(self._compute_distribution)

    def published(self, device: Device, size: Size) -> Evidence | None:
        """Evidence of published facts about the device's model, if any."""
        return published(facts_about(self.facts, device), device, size)

    def family(self, device: Device, size: Size) -> Population | None:
        """Distribution of the maker's cameras of this kind, if enough are known."""
        return self._distribution(device.kind, device.maker, _aspect(size)) if device.maker else None

    def population(self, device: Device, size: Size) -> Population:
        """Distribution of the kind of device."""
        size = _aspect(size)
        distribution = self._distribution(device.kind, "", size)
        if distribution is None or distribution.n < _MIN_POPULATION:
            distribution = self._distribution(_FALLBACK, "", size)
        if distribution is None:
            raise ValueError("the table has no facts")
        return distribution

    def _compute_distribution(self, kind: str, maker: str, size: Size) -> Population | None:
        values = by_model(members(self.facts, kind), size)
        if maker:
            return family(values, maker)
        return population(list(values.values())) if len(values) > 1 else None


@functools.cache
def default_knowledge() -> Knowledge:
    """Knowledge of the whole table."""
    return Knowledge(all_facts())


def _aspect(size: Size) -> Size:
    """Rounded aspect, so that few populations are computed."""
    return math.exp(round(aspect_log(size), 2)), 1.0
