"""`make bench DOCS=estimates`: do the intervals of estimates hold? Real data.

Every camera whose field of view is known is left out of the table, estimated from the rest, and compared.
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
"""Beginning of groups of recorded pictures, which no total counts."""
MEASURED = ("calibration", "measurement", "reported")
Item = TypeVar("Item")
Key = TypeVar("Key")


@dataclass(frozen=True)
class Case:
    """One camera that was left out: its horizontal field of view and the interval, degrees.

    `group`: kind of evidence that the table shows apart. Several sizes of a `camera` may be cases.
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


def model_of(fact: Fact) -> tuple[str, str]:
    return fact.maker, fact.model


def is_aspect(fact: Fact) -> bool:
    return fact.size[0] < 64


def device(fact: Fact) -> Device:
    words = max(fact.words, key=len) if fact.words else frozenset[str]()
    return Device(fact.kind, fact.maker, fact.camera, fact.devices, words)


def without(*models: tuple[str, str]) -> Knowledge:
    return Knowledge(fact for fact in all_facts() if model_of(fact) not in models)


def estimated(of: Device, size: tuple[float, float], about: Sequence[Fact]) -> Distribution:
    stated = published(about, of, size)
    return combine_evidence(without(*map(model_of, about)), of, size, [stated] if stated else [])


def about_same_camera(fact: Fact) -> list[Fact]:
    camera = (*model_of(fact), fact.camera)
    return [f for f in all_facts() if (*model_of(f), f.camera) == camera and f is not fact]


def sources_left_out() -> Iterator[Case]:
    """Each source that measured a model, estimated from the model's other sources."""
    for fact in all_facts():
        others = [f for f in about_same_camera(fact) if f.url != fact.url]
        if fact.what in MEASURED and fact.title != lens_facts.TITLE and others and not is_aspect(fact):
            result = estimated(device(fact), fact.size, others)
            yield Case.of("webcams, depth cameras and phones, by model", fact.model, fact.log_tan, result)


def models_left_out(*, by_maker: bool) -> Iterator[Case]:
    """Each model, estimated from the other models of its maker and kind, or of its kind."""
    for kind, group in KINDS.items():
        own = members(all_facts(), kind)
        for model in sorted(set(map(model_of, own))):
            about = [f for f in own if model_of(f) == model]
            size = about[0].size
            asked = Device(kind, model[0] if by_maker else "", about[0].camera)
            result = combine_evidence(without(model), asked, size, [])
            if result.best.basis == ("family" if by_maker else "population"):
                yield Case.of(group, " ".join(model), by_model(about, size)[model], result)


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


def profiles() -> Iterator[tuple[dict[str, str], float, tuple[str, str], str]]:
    """Lens profiles of action cameras: row, angle, maker and model, mode."""
    with (data_dir() / "lens_profiles.csv").open(newline="", encoding="utf-8") as file:
        for row, angle in lens_facts.usable(csv.DictReader(file)):
            kind, maker, model, mode, _ = lens_facts.identity(row)
            if kind == "action":
                yield row, angle, (maker, model), mode


def contributors_left_out() -> Iterator[Case]:
    """Each contributor's profile of an action camera, estimated from other contributors' profiles."""
    for model, own in grouped(profiles(), lambda profile: profile[2]).items():
        stated = [f for f in all_facts() if model_of(f) == model and f.title != lens_facts.TITLE]
        for contributor, left_out in grouped(own, lambda profile: profile[0]["contributor"]).items():
            others = [(row, angle) for row, angle, *_ in own if row["contributor"] != contributor]
            about = [*stated, *(fact_of(row) for row in lens_facts.facts(others))]
            if not about:
                continue
            for mode, (profile, *_) in sorted(grouped(left_out, lambda profile: profile[3]).items()):
                row, angle, *_ = profile
                named = Device("action", model[0], label_words=frozenset({mode}))
                result = estimated(named, (float(row["w"]), float(row["h"])), about)
                group = "files: action cameras, by model" + (" and mode" if mode else "")
                yield Case.of(group, " ".join(model), math.log(math.tan(angle / 2)), result)


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    groups: dict[Key, list[Item]] = defaultdict(list)
    for item in items:
        groups[key(item)].append(item)
    return groups


def calibrations_left_out(*, same_size: bool) -> Iterator[Case]:
    """Each published calibration, estimated from one to four others at its size, or one at another size."""
    for fact in all_facts():
        if not is_calibration(fact) or fact.title == lens_facts.TITLE:
            continue
        others = [
            f
            for f in about_same_camera(fact)
            if is_calibration(f)
            and (f.size == fact.size) == same_size
            and not (same_size and f.url == fact.url)
        ][:4]
        if not others:
            continue
        if same_size:
            evidence = calibrated(fact.kind, statistics.median(f.log_tan for f in others), len(others))
        else:
            evidence = other_size(fact.kind, others[0].log_tan, others[0].size, fact.size, 1)
        asked = replace(device(fact), label_words=frozenset())
        result = combine_evidence(without(model_of(fact)), asked, fact.size, [evidence])
        yield Case.of("webcams, depth cameras and phones", fact.model, fact.log_tan, result)


def is_calibration(fact: Fact) -> bool:
    return fact.what == "calibration" and not is_aspect(fact)


def reports_left_out() -> Iterator[Case]:
    """Each phone's calibrated field, estimated from the focal length in the EXIF of its photographs."""
    with_exif = {
        (row["maker"], row["model"]): float(row["value"])
        for row in rows()
        if (row["quantity"], row["what"], row["camera"]) == ("f35", "reported", "wide")
    }
    for fact in all_facts():
        focal = with_exif.get(model_of(fact))
        if (fact.what, fact.kind, fact.camera) != ("calibration", "phone_rear", "wide") or focal is None:
            continue
        evidence = [reported(fact.kind, "f35", focal, fact.size)]
        asked = replace(device(fact), label_words=frozenset(), model_ids=frozenset())
        result = combine_evidence(without(model_of(fact)), asked, fact.size, evidence)
        yield Case.of("phones, EXIF against calibrations", fact.model, fact.log_tan, result)


def summary(cases: Sequence[Case], name: str) -> list[str]:
    held = statistics.mean(case.holds for case in cases)
    width = statistics.median(case.width for case in cases)
    cameras = {case.camera for case in cases}
    shares = (f"{100 * share:.0f} %" for share in (held, width, needed(cases)))
    return [name, str(len(cameras)), str(len(cases)), *shares]


def needed(cases: Sequence[Case]) -> float:
    """Relative width of equally wide intervals around the same centres that contain 90 % of the truths."""
    deviations = sorted(case.deviation for case in cases)
    return 2 * deviations[math.ceil(0.9 * len(deviations)) - 1]


def coverage(cases: Sequence[Case]) -> str:
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
    for kind, (slope, sigma, _) in SLOPES.items():
        found = []
        for about in grouped(members(all_facts(), kind), model_of).values():
            measured = [f for f in about if f.what != "specification" or f.kind == "depth_camera"]
            wide = [f.log_tan for f in measured if is_same_aspect(f.size, (16, 9))]
            narrow = [f.log_tan for f in measured if is_same_aspect(f.size, (4, 3))]
            if wide and narrow:
                found.append((statistics.median(wide) - statistics.median(narrow)) / math.log(4 / 3))
        if len(found) > 1:
            figures = f"{statistics.mean(found):.2f}", f"{statistics.stdev(found):.2f}"
            rows.append([KINDS.get(kind, kind), str(len(found)), *figures, f"{slope:.2f} ± {sigma:.2f}"])
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
    "calibrations": lambda: calibrations_left_out(same_size=True),
    "device": reports_left_out,
    "other size": lambda: calibrations_left_out(same_size=False),
    "published": sources_left_out,
    "action cameras": contributors_left_out,
    "family": lambda: models_left_out(by_maker=True),
    "population": lambda: models_left_out(by_maker=False),
}


def main() -> None:
    cases: list[Case] = []
    for _, step in announce("estimates", list(STEPS.items()), lambda step: step[0]):
        cases += step()
    document.replace("coverage", coverage(cases), DOCUMENT)
    document.replace("populations", populations(), DOCUMENT)
    document.replace("slopes", slopes(), DOCUMENT)


if __name__ == "__main__":
    main()
