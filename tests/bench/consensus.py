"""`make bench DOCS=consensus`: how far liars get, and what published lens profiles become.

`CAMERAS=1000` simulated cameras; `ONLY=poisoning` or `ONLY="lens profiles"`.
"""

import itertools
import os
from collections.abc import Sequence

import numpy as np

from calibsolver import CalibrationError, Camera
from calibsolver.consensus import Member, pool
from infra.console import track
from tests.bench import document
from tests.helpers.solver import attacks, populations

MAX_DRAWS = 60
"""Of one mode at most."""
LENS_DRAWS = 500
ATTACKS: tuple[tuple[float, str, int, float], ...] = (
    (0.0, "as others", 2, 1.0),
    (0.001, "as others", 2, 0.3),
    (0.003, "as others", 2, 0.3),
    (0.001, "as others", 1, 0.3),
    *((0.001, views, liars, 0.2) for views in attacks.EFFORTS for liars in (1, 2)),
)
"""Spread of specimens, views of the liars, liars, and share of the cameras."""
HEADER = [
    *(
        "spread of specimens",
        "liars",
        "their views",
        "cameras",
        "reliable without lies",
        "reliable with lies",
    ),
    *("moved by > 0.5 px", "moved by > 1 px", "largest move", "95th percentile"),
    *("moved by > 0.5 px and > the stated spread", "control: reliable"),
    *("control: moved by > 0.5 px", "control: 95th percentile"),
]


def main() -> None:
    cameras = int(os.environ.get("CAMERAS", "1000"))
    for name, written in (("poisoning", lambda: poisoning(cameras)), ("lens profiles", profiles)):
        if document.is_chosen(name):
            document.replace(name, written())


def poisoning(cameras: int) -> str:
    rows = []
    for variation, views, liars, share in ATTACKS:
        number, effort = int(cameras * share), attacks.EFFORTS.get(views)
        trials = [
            run_trial(i, variation, effort, liars)
            for i in track(range(number), f"variation {variation}, {liars}, {views}", number)
        ]
        rows.append([f"{variation:.1%}", str(liars), views, *cells(trials)])
    return document.table(HEADER, rows)


def run_trial(number: int, variation: float, effort: attacks.Effort | None, liars: int) -> attacks.Trial:
    rng, others = np.random.default_rng((7, number)), np.random.default_rng((8, number))
    kind, total = attacks.KINDS[number % 4], int(rng.integers(5, 13))
    return attacks.trial(rng, kind, total, variation, others=others, effort=effort, liars=liars)


def cells(trials: Sequence[attacks.Trial]) -> list[str]:
    pairs = [(t.moved, t.attacked.spread) for t in trials if t.attacked and t.reliable]
    moved = [move for move, _ in pairs]
    scatter = [t.by_honest for t in trials if t.by_honest is not None]
    return [
        f"{len(trials):,}",
        f"{np.mean([t.clean.total < 5 or t.clean.reliable for t in trials]):.1%}",
        f"{len(moved) / len(trials):.1%}",
        str(sum(m > attacks.MOVED for m in moved)),
        str(sum(m > 1 for m in moved)),
        f"{np.max(moved):.2f} px",
        f"{np.quantile(moved, 0.95):.2f} px",
        str(sum(move > max(attacks.MOVED, spread) for move, spread in pairs)),
        f"{len(scatter) / len(trials):.1%}",
        str(sum(m > attacks.MOVED for m in scatter)),
        f"{np.quantile(scatter, 0.95):.2f} px",
    ]


def profiles() -> str:
    rng = np.random.default_rng(3)
    modes = {mode: found for mode, found in populations.profiles().items() if len(found) >= 5}
    seen = {mode: populations.members(found, rng) for mode, found in modes.items()}
    rates = {mode: rate(seen[mode], modes[mode], rng) for mode in modes}
    rows = []
    for what, chosen in (
        ("lens and setting both named", [mode for mode in modes if mode[2] and mode[3]]),
        ("lens or setting named", [mode for mode in modes if mode[2] or mode[3]]),
        ("all, unnamed settings too", list(modes)),
    ):
        mean = np.mean([rates[mode] for mode in chosen], axis=0)
        rows.append([what, str(len(chosen)), f"{mean[0]:.1%}", f"{mean[1]:.1%}"])
    whole = np.mean([is_reliable(seen[mode], found[0][0].img_size) for mode, found in modes.items()])
    rows.append(["all profiles of a mode at once", str(len(modes)), f"{whole:.1%}", ""])
    wrong = reliable_across_lenses(rng)
    rows.append([f"five lenses, one camera ({LENS_DRAWS} draws)", "", f"{wrong:.1%}", ""])
    return document.table(["draws of five from", "modes", "reliable", "fx, fy, cx, cy agree"], rows)


def rate(
    members: Sequence[Member], found: Sequence[tuple[Camera, float]], rng: np.random.Generator
) -> Sequence[float]:
    """Share of the draws of five that are reliable, and of those that could be by their intrinsics only."""
    draws = list(itertools.combinations(range(len(members)), 5))
    if len(draws) > MAX_DRAWS:
        draws = [draws[i] for i in rng.choice(len(draws), MAX_DRAWS, replace=False)]
    reliable = [is_reliable([members[i] for i in draw], found[0][0].img_size) for draw in draws]
    possible = [is_within_rule([found[i][0] for i in draw]) for draw in draws]
    return float(np.mean(reliable)), float(np.mean(possible))


def is_reliable(members: Sequence[Member], img_size: tuple[int, int]) -> bool:
    try:
        return pool(members, img_size, "fisheye").reliable
    except CalibrationError:
        return False


def is_within_rule(cameras: Sequence[Camera]) -> bool:
    """True if focal lengths and centres spread by less than the rule's 5 % and 2 %: no draw can do better."""
    k = np.stack([camera.intrinsics[:4] for camera in cameras])
    focal = k[:, :2].std(axis=0) / k[:, :2].mean(axis=0)
    return bool((focal < 0.05).all() and (k[:, 2:].std(axis=0) / cameras[0].img_size < 0.02).all())


def reliable_across_lenses(rng: np.random.Generator) -> float:
    """Share of the draws of five lenses of one camera, at one size, that are called reliable."""
    cameras: dict[tuple[str, ...], dict[str, list[tuple[Camera, float]]]] = {}
    for (brand, model, lens, _, w, h), found in populations.profiles().items():
        if lens:
            cameras.setdefault((brand, model, w, h), {}).setdefault(lens.lower(), []).extend(found)
    many = [lenses for lenses in cameras.values() if len(lenses) >= 5]
    wrong = 0
    for _ in range(LENS_DRAWS):
        lenses = many[int(rng.integers(len(many)))]
        names = rng.choice(sorted(lenses), 5, replace=False)
        drawn = [lenses[name][int(rng.integers(len(lenses[name])))] for name in names]
        wrong += is_reliable(populations.members(drawn, rng), drawn[0][0].img_size)
    return wrong / LENS_DRAWS


if __name__ == "__main__":
    main()
