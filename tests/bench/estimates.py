"""`make bench DOCS=estimates`: do the intervals of estimates hold? Writes docs/estimates.md.

Every camera whose field of view is known is left out of the table, estimated from the rest, and compared: a
published source about a model from the other sources, a model from its maker's others, and from its kind's; a
contributor's lens profile from the profiles of other contributors. Real data; no camera is simulated.
"""

import csv
import math
import statistics
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from calibdb.estimate.angles import horizontal_angle
from calibdb.estimate.crops import SLOPES, is_same_aspect
from calibdb.estimate.device import Device
from calibdb.estimate.estimator import Distribution, combine_evidence
from calibdb.estimate.facts import Fact, all_facts, fact_of, rows
from calibdb.estimate.knowledge import Knowledge
from calibdb.estimate.own import calibrated, other_size, reported
from calibdb.estimate.population import by_model, members
from calibdb.estimate.published import published
from infra.console import announce
from infra.web_build import lens_facts
from tests.bench import document
from tests.helpers.data import ROOT, data_dir

DOCUMENT = ROOT / "docs" / "estimates.md"
HEADER = ["basis", "cameras", "intervals", "contain the truth", "median width", "needed"]
FILES = "files: "
"""Beginning of groups whose truths are of recorded pictures, not of live cameras; no total counts them."""
MEASURED = ("calibration", "measurement", "reported")
Item = TypeVar("Item")
Key = TypeVar("Key")
Profiles = Sequence[tuple[dict[str, str], float]]


@dataclass(frozen=True)
class Case:
    """One camera that was left out.

    Attributes
    ----------
    basis, group
        Basis of the estimate, and kind of evidence that the table shows apart.
    camera
        Camera, of which several sizes may be cases.
    truth, low, high
        Horizontal field of view and the interval, degrees.
    """

    basis: str
    group: str
    camera: str
    truth: float
    low: float
    high: float

    @classmethod
    def of(cls, group: str, camera: str, truth: float, result: Distribution) -> "Case":
        """Compare an estimate with the truth, both as `log_tan`."""
        angles = (horizontal_angle(value) for value in (truth, result.low, result.high))
        return cls(result.best.basis, group, camera, *angles)

    @property
    def holds(self) -> bool:
        return self.low <= self.truth <= self.high

    @property
    def width(self) -> float:
        return (self.high - self.low) / self.truth

    @property
    def deviation(self) -> float:
        """Deviation of the truth from the interval's centre, relative."""
        return abs(math.log(self.truth / math.sqrt(self.low * self.high)))


def is_aspect(fact: Fact) -> bool:
    """True if `size` is an aspect only, such as 16, 9."""
    return fact.size[0] < 64


def device(fact: Fact) -> Device:
    """Device that a fact is about, its model named."""
    words = max(fact.words, key=len) if fact.words else frozenset[str]()
    return Device(fact.kind, fact.maker, fact.camera, fact.devices, words)


def sources_left_out() -> Iterator[Case]:
    """Each source that measured a model, estimated from the model's other sources."""
    facts = all_facts()
    for fact in facts:
        others = [
            f
            for f in facts
            if (f.maker, f.model, f.camera) == (fact.maker, fact.model, fact.camera) and f.url != fact.url
        ]
        if fact.what not in MEASURED or fact.title == lens_facts.TITLE or not others or is_aspect(fact):
            continue
        result = estimated(device(fact), fact.size, facts, others)
        yield Case.of("webcams, depth cameras and phones, by model", fact.model, fact.log_tan, result)


def estimated(
    of: Device, size: tuple[float, float], facts: Sequence[Fact], about: Sequence[Fact]
) -> Distribution:
    """Estimate from facts about the model, and the rest of the table without the model."""
    rest = [f for f in facts if not any((f.maker, f.model) == (a.maker, a.model) for a in about)]
    stated = published(about, of, size)
    return combine_evidence(Knowledge(rest), of, size, [stated] if stated else [])


def models_left_out(*, by_maker: bool) -> Iterator[Case]:
    """Each model, estimated from the other models of its maker and kind, or of its kind."""
    facts = all_facts()
    for kind in KINDS:
        own = members(facts, kind)
        for maker, model in sorted({(f.maker, f.model) for f in own}):
            about = [f for f in own if (f.maker, f.model) == (maker, model)]
            size = about[0].size
            truth = by_model(about, size)[maker, model]
            rest = Knowledge(f for f in facts if (f.maker, f.model) != (maker, model))
            asked = Device(kind, maker if by_maker else "", about[0].camera)
            result = combine_evidence(rest, asked, size, [])
            if result.best.basis == ("family" if by_maker else "population"):
                yield Case.of(KINDS.get(kind, kind), f"{maker} {model}", truth, result)


KINDS = {
    "usb_webcam": "USB webcams",
    "laptop_builtin": "built-in cameras",
    "camera_module": "camera modules",
    "depth_camera": "depth cameras",
    "phone_rear": "phones, rear",
    "phone_front": "phones, front",
    "phone_ultrawide": "phones, ultra-wide",
    "tablet_rear": "tablets, rear",
    "action": "files: action cameras",
    "drone": "files: drones",
    "headset": "headsets",
    "phone_video": "files: phones, recorded video",
    "photo_camera": "files: cameras with interchangeable lenses",
}


def profiles() -> Profiles:
    """Lens profiles of action cameras."""
    with (data_dir() / "lens_profiles.csv").open(newline="", encoding="utf-8") as file:
        usable = lens_facts.usable(csv.DictReader(file))
    return [profile for profile in usable if lens_facts.identity(profile[0])[0] == "action"]


def contributors_left_out() -> Iterator[Case]:
    """Each contributor's profile of an action camera, estimated from other contributors' profiles."""
    everything = profiles()
    facts = all_facts()
    for (maker, model), own in grouped(everything, lambda p: lens_facts.identity(p[0])[1:3]).items():
        stated = [f for f in facts if (f.maker, f.model) == (maker, model) and f.title != lens_facts.TITLE]
        for contributor, left_out in grouped(own, lambda p: p[0]["contributor"]).items():
            others = [p for p in own if p[0]["contributor"] != contributor]
            about = [*stated, *(fact_of(row) for row in lens_facts.facts(others))]
            if not about:
                continue
            for mode in sorted({lens_facts.identity(p[0])[3] for p in left_out}):
                row, angle = next(p for p in left_out if lens_facts.identity(p[0])[3] == mode)
                size = (float(row["w"]), float(row["h"]))
                named = Device("action", maker, label_words=frozenset({mode}))
                result = estimated(named, size, facts, about)
                group = "files: action cameras, by model" + (" and mode" if mode else "")
                yield Case.of(group, f"{maker} {model}", math.log(math.tan(angle / 2)), result)


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    groups: dict[Key, list[Item]] = defaultdict(list)
    for item in items:
        groups[key(item)].append(item)
    return groups


def calibrations_left_out() -> Iterator[Case]:
    """Each published calibration at a size, estimated from one to four others at this size."""
    yield from _own_calibrations(all_facts(), same=True)


def sizes_left_out() -> Iterator[Case]:
    """Each published calibration, estimated from one at another size of the same model."""
    yield from _own_calibrations(all_facts(), same=False)


def _own_calibrations(facts: Sequence[Fact], *, same: bool) -> Iterator[Case]:
    for fact in facts:
        if fact.what != "calibration" or is_aspect(fact) or fact.title == lens_facts.TITLE:
            continue
        model = [f for f in facts if (f.maker, f.model, f.camera) == (fact.maker, fact.model, fact.camera)]
        others = [
            f
            for f in model
            if f.what == "calibration"
            and f is not fact
            and not is_aspect(f)
            and (f.size == fact.size) == same
            and (f.url != fact.url or not same)
        ]
        if not others:
            continue
        rest = Knowledge(f for f in facts if (f.maker, f.model) != (fact.maker, fact.model))
        mean = statistics.median(f.log_tan for f in others[:4])
        if same:
            evidence = [calibrated(fact.kind, mean, min(len(others), 4))]
        else:
            evidence = [other_size(fact.kind, f.log_tan, f.size, fact.size, 1) for f in others[:1]]
        result = combine_evidence(rest, replace(device(fact), label_words=frozenset()), fact.size, evidence)
        yield Case.of("webcams, depth cameras and phones", fact.model, fact.log_tan, result)


def reports_left_out() -> Iterator[Case]:
    """Each phone's calibrated field, estimated from the focal length in the EXIF of its photographs."""
    facts = [f for f in all_facts() if f.camera == "wide"]
    with_exif = {
        (row["maker"], row["model"]): float(row["value"])
        for row in rows()
        if (row["quantity"], row["what"], row["camera"]) == ("f35", "reported", "wide")
    }
    for fact in facts:
        focal = with_exif.get((fact.maker, fact.model))
        if fact.what != "calibration" or focal is None or fact.kind != "phone_rear":
            continue
        rest = Knowledge(f for f in facts if (f.maker, f.model) != (fact.maker, fact.model))
        evidence = [reported(fact.kind, "f35", focal, fact.size)]
        asked = replace(device(fact), label_words=frozenset(), model_ids=frozenset())
        yield Case.of(
            "phones, EXIF against calibrations",
            fact.model,
            fact.log_tan,
            combine_evidence(rest, asked, fact.size, evidence),
        )


def summary(cases: Sequence[Case], name: str) -> list[str]:
    held = sum(case.holds for case in cases) / len(cases)
    width = statistics.median(case.width for case in cases)
    return [
        name,
        str(len({c.camera for c in cases})),
        str(len(cases)),
        f"{100 * held:.0f} %",
        f"{100 * width:.0f} %",
        f"{100 * needed(cases):.0f} %",
    ]


def needed(cases: Sequence[Case]) -> float:
    """Relative width of equally wide intervals around the same centres that contain 90 % of the truths."""
    deviations = sorted(case.deviation for case in cases)
    return 2 * deviations[math.ceil(0.9 * len(deviations)) - 1]


def tables(cases: Sequence[Case]) -> str:
    """Table of coverage and width: each basis, and its groups."""
    rows = []
    for basis, own in grouped(cases, lambda c: c.basis).items():
        rows.append(summary([c for c in own if not c.group.startswith(FILES)], f"**{basis}**"))
        groups = grouped(own, lambda c: c.group)
        if len(groups) > 1:
            rows += [summary(some, group) for group, some in groups.items()]
    return document.table(HEADER, rows)


def slopes() -> str:
    """Slopes of the table: models with calibrations at 4:3 and at 16:9."""
    rows = []
    for kind in SLOPES:
        found = []
        for about in grouped(members(all_facts(), kind), lambda f: (f.maker, f.model)).values():
            measured = [f for f in about if f.what != "specification" or f.kind == "depth_camera"]
            wide = [f.log_tan for f in measured if is_same_aspect(f.size, (16, 9))]
            narrow = [f.log_tan for f in measured if is_same_aspect(f.size, (4, 3))]
            if wide and narrow:
                found.append((statistics.median(wide) - statistics.median(narrow)) / math.log(4 / 3))
        if len(found) > 1:
            slope, sigma, _ = SLOPES[kind]
            rows.append(
                [
                    KINDS.get(kind, kind),
                    str(len(found)),
                    f"{statistics.mean(found):.2f}",
                    f"{statistics.stdev(found):.2f}",
                    f"{slope:.2f} ± {sigma:.2f}",
                ]
            )
    return document.table(["kind", "models", "mean", "deviation", "used"], rows)


def populations() -> str:
    knowledge = Knowledge(all_facts())
    rows = []
    for kind, name in {**KINDS, "webcam": "USB or built-in, not known which"}.items():
        for size in ((16, 9), (4, 3)):
            found = knowledge.population(Device(kind), size)
            angles = [f"{horizontal_angle(v):.0f}" for v in (found.low, found.median, found.high)]
            rows.append([name, f"{size[0]}:{size[1]}", str(found.n), *angles])
    return document.table(["kind", "picture", "models", "5 %", "median", "95 %"], rows)


STEPS: dict[str, Callable[[], Iterator[Case]]] = {
    "calibrations": calibrations_left_out,
    "device": reports_left_out,
    "other size": sizes_left_out,
    "published": sources_left_out,
    "action cameras": contributors_left_out,
    "family": lambda: models_left_out(by_maker=True),
    "population": lambda: models_left_out(by_maker=False),
}


def main() -> None:
    """Measure, and write the tables."""
    cases: list[Case] = []
    for _, step in announce("estimates", list(STEPS.items()), lambda step: step[0]):
        cases += step()
    document.replace("coverage", tables(cases), DOCUMENT)
    document.replace("populations", populations(), DOCUMENT)
    document.replace("slopes", slopes(), DOCUMENT)


if __name__ == "__main__":
    main()
