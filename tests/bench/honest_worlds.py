"""Liars among contributors whose specimens, boards, noise and care differ: a part of `consensus`."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibsolver.consensus import Member, Rule, difference, pool
from infra.console import track
from tests.bench import document
from tests.helpers.solver import worlds

RULE = Rule(min_contributors=3)
MOVED = 1.0
"""px over the image of 1,280, by which no liar may move a reliable answer."""
MAX_HONEST = 12
HEADER = [
    *("contributors", "cameras", "reliable", "moved by > 1 px", "largest move", "95th percentile"),
    "moved by > 1 px while the stated uncertainty fell",
]


@dataclass(frozen=True)
class Answer:
    """A consensus, and how far it lies from that without liars: px; its stated uncertainty over that's."""

    reliable: bool
    moved: float = 0.0
    uncertainty_ratio: float = 1.0


@dataclass(frozen=True)
class Outcome:
    """Answers for one camera with `honest` contributors, for its first five, and with one and two liars."""

    honest: int
    first_five: Answer
    clean: Answer
    one: Answer
    two: Answer


def run_trial(number: int) -> Outcome:
    """Run the trial of this number, the same one every time: half of the cameras have five contributors.

    Lies are of the focal length or of the distortion, alternately; of two liars half tell the same lie. Every
    third liar has the densest board, the others any.
    """
    rng = np.random.default_rng((17, number))
    product = worlds.world(rng)
    honest = 5 if number % 2 else int(rng.integers(6, MAX_HONEST + 1))
    members = [worlds.member(f"h{i}", worlds.specimen(product, rng), rng) for i in range(honest)]
    kind = ("focal", "distortion")[number // 2 % 2]
    false = worlds.lie(product.camera, kind, rng)
    other = false if rng.uniform() < 0.5 else worlds.lie(product.camera, kind, rng)
    corners = worlds.CORNERS[1] if number % 3 == 0 else None
    liars = [worlds.member(f"l{i}", camera, rng, corners) for i, camera in enumerate((false, other))]
    size, model = product.camera.img_size, product.camera.model
    clean = pool(members, size, model, RULE)
    certain = clean.calibration.uncertainty().rms

    def compared(liars: Sequence[Member]) -> Answer:
        found = pool([*members, *liars], size, model, RULE)
        moved = difference(clean.calibration.camera, found.calibration.camera)
        return Answer(found.reliable, moved, found.calibration.uncertainty().rms / certain)

    five = clean if honest == 5 else pool(members[:5], size, model, RULE)
    answers = Answer(five.reliable), Answer(clean.reliable), compared(liars[:1]), compared(liars)
    return Outcome(honest, *answers)


def table(cameras: int) -> str:
    outcomes = [run_trial(number) for number in track(range(cameras), "honest worlds", cameras)]
    rows = [row("five, no attacker", [o.first_five for o in outcomes])]
    for what, chosen in (
        ("five", [o for o in outcomes if o.honest == 5]),
        (f"six to {MAX_HONEST}", [o for o in outcomes if o.honest > 5]),
        ("all", outcomes),
    ):
        if what != "five":
            rows.append(row(f"{what}, no attacker", [o.clean for o in chosen]))
        rows.append(row(f"{what}, and one attacker", [o.one for o in chosen], lies=True))
        rows.append(row(f"{what}, and two attackers", [o.two for o in chosen], lies=True))
    return document.table(HEADER, rows)


def row(what: str, answers: Sequence[Answer], *, lies: bool = False) -> list[str]:
    reliable = [a for a in answers if a.reliable]
    start = [what, f"{len(answers):,}", f"{len(reliable) / len(answers):.1%}"]
    if not lies:
        return [*start, "", "", "", ""]
    moved = [a.moved for a in reliable]
    return [
        *start,
        str(sum(m > MOVED for m in moved)),
        f"{max(moved):.2f} px",
        f"{np.quantile(moved, 0.95):.2f} px",
        str(sum(a.moved > MOVED and a.uncertainty_ratio < 1 for a in reliable)),
    ]
