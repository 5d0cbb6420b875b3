"""Published values of a model, as evidence about another unit and size."""

import math
import statistics
from collections import defaultdict
from collections.abc import Sequence

from calibdb.estimate.angles import Size
from calibdb.estimate.crops import is_same_aspect, transfer
from calibdb.estimate.device import Device
from calibdb.estimate.evidence import Evidence, combine, mixture
from calibdb.estimate.facts import Fact
from calibdb.schema.estimate import Source

# Standard deviation of log tan(hfov / 2) between calibrations of two units of a model.
_UNIT_SIGMA = {"usb_webcam": 0.023, "laptop_builtin": 0.03, "depth_camera": 0.012, "camera_module": 0.03}
_OTHER_UNIT_SIGMA = 0.01  # phones and the rest
MAX_SOURCES = 5


def facts_about(facts: Sequence[Fact], device: Device) -> list[Fact]:
    """Facts about the device's model, by USB id, else phone's identifier, else words."""
    label = device.label_words
    # An app records a crop of what a browser gets: facts about recorded videos precede others.
    recorded = device.kind == "phone_video"
    for counted in (
        ((1, fact) for fact in facts if device.usb_id in fact.usb),
        ((1, fact) for fact in facts if device.model_ids & fact.devices),
        ((len(words), fact) for fact in facts for words in fact.words if words <= label),
    ):
        fitting = [(count, fact) for count, fact in counted if fact.camera == device.camera]
        same = [(count, fact) for count, fact in fitting if (fact.kind == "phone_video") == recorded]
        chosen = same or (fitting if recorded else [])
        if chosen:
            most = max(count for count, _ in chosen)  # `brio 501` before `brio`
            return list(dict.fromkeys(fact for count, fact in chosen if count == most))
    return []


def published(facts: Sequence[Fact], device: Device, size: Size) -> Evidence | None:
    """Evidence for this size from all facts about the model, if any."""
    if not facts:
        return None
    modes: dict[str, list[Fact]] = defaultdict(list)
    for fact in facts:
        modes[fact.mode].append(fact)
    named = [mode for mode in modes if mode and mode in device.label_words]
    parts = [(_weight(modes[mode]), *_one_mode(modes[mode], size)) for mode in named or modes]
    mean, sigma = mixture(parts)
    return Evidence("published", mean, sigma, _sources(facts), _lens(facts))


def _weight(facts: Sequence[Fact]) -> float:
    return float(sum(fact.n for fact in facts))


def _one_mode(facts: Sequence[Fact], size: Size) -> tuple[float, float]:
    """Mean and standard deviation of `log_tan` at `size`, by facts of one mode."""
    groups: dict[tuple[bool, bool], list[Fact]] = defaultdict(list)
    for fact in facts:
        groups[is_same_aspect(fact.size, size), fact.what == "specification"].append(fact)
    if any(fact.n > 1 and is_same_aspect(fact.size, size) for fact in facts):
        # The deviation of such a row is that of its units, which other rows do not reduce.
        groups = {key: group for key, group in groups.items() if key[0]}
    mean, sigma = combine([_group(group, size) for group in groups.values()])
    return mean, math.hypot(sigma, _unit_sigma(facts))


def _unit_sigma(facts: Sequence[Fact]) -> float:
    return max(_UNIT_SIGMA.get(fact.kind, _OTHER_UNIT_SIGMA) for fact in facts)


def _group(facts: Sequence[Fact], size: Size) -> Evidence:
    """Evidence of facts that share the error of the transfer."""
    exact = [fact for fact in facts if fact.size == size]
    facts = exact or facts
    values, sigmas = [], []
    for fact in facts:
        change, sigma = transfer(fact.kind, fact.size, size, same_size=bool(exact))
        values.append(fact.log_tan + change)
        sigmas.append(sigma)
    own = statistics.median(fact.sigma for fact in facts)
    # Specifications repeat one number; calibrations are of different units.
    repeated = facts[0].what == "specification"
    spread = own if repeated else math.hypot(own, _unit_sigma(facts)) / math.sqrt(len(facts))
    return Evidence("published", statistics.median(values), math.hypot(spread, statistics.median(sigmas)))


def _sources(facts: Sequence[Fact]) -> tuple[Source, ...]:
    unique = dict.fromkeys((fact.title, fact.url) for fact in facts)
    return tuple(Source(title=title, url=url) for title, url in list(unique)[:MAX_SOURCES])


def _lens(facts: Sequence[Fact]) -> tuple[float, ...]:
    lenses = [fact for fact in facts if fact.lens]
    return max(lenses, key=lambda fact: fact.n).lens if lenses else ()
