"""`make bench DOCS=contributors`: a consensus of five contributors whose boards bend, each in its own way.

Simulated: 12 cameras, six guided views per contributor, noise 0.3 px. The middle of a board is off its plane
by 0.02 squares (standard deviation) and a hand moves it by 0.5 px between the middle row and the rim.
"""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from unittest.mock import patch

import numpy as np

from calibsolver import Camera, fit
from calibsolver.consensus import Member, Rule, pool
from calibsolver.consensus.fit_memory import fit_once
from infra.console import track
from tests.bench import document
from tests.helpers.solver import hands, populations, synthetic

CONTRIBUTORS, VIEWS, NOISE = 5, 6, 0.3
ROUNDS = 4  # worlds per camera
BEND_SQUARES = 0.02
"""Standard deviation of the height of a board's middle."""
HAND = hands.Hand(readout_s=0.02, speed_cm_s=1.0, turn_deg_s=2.0)
RULE = Rule(min_contributors=3)
HEADER = ["board", "reliable", "one contributor, px", "consensus, px", "largest", "stated", "within twice it"]
as_drawn = partial(fit, board_shape=False)


@dataclass(frozen=True)
class Outcome:
    """Consensus of one world: error, stated error and contributors' errors, px rms over the image."""

    reliable: bool
    error: float
    stated: float
    own: tuple[float, ...]


def members(camera: Camera, rng: np.random.Generator) -> list[Member]:
    out = []
    for i in range(CONTRIBUTORS):
        sag = abs(BEND_SQUARES * rng.normal()) / max(populations.BOARD.size)
        views = populations.views(camera, rng, NOISE, VIEWS, replace(HAND, sag_boards=sag))
        out.append(Member(str(i), str(i), tuple(views)))
    return out


def outcome(camera: Camera, given: list[Member], *, drawn: bool) -> Outcome:
    fitted = as_drawn if drawn else fit_once
    with patch("calibsolver.consensus.pooling.fit_once", as_drawn) if drawn else nullcontext():
        found = pool(given, camera.img_size, camera.model, RULE)
    own = (fitted(m.views, camera.img_size, camera.model).camera for m in given)
    return Outcome(
        found.reliable,
        synthetic.rms_error(camera, found.calibration.camera),
        found.calibration.uncertainty().rms,
        tuple(synthetic.rms_error(camera, each) for each in own),
    )


def row(name: str, outcomes: list[Outcome]) -> list[str]:
    errors, stated = (np.array([getattr(o, part) for o in outcomes]) for part in ("error", "stated"))
    return [
        name,
        f"{np.mean([o.reliable for o in outcomes]):.0%}",
        f"{np.median([o.own for o in outcomes]):.2f}",
        f"{np.median(errors):.2f}",
        f"{errors.max():.2f}",
        f"{np.median(stated):.2f}",
        f"{np.mean(errors <= 2 * stated):.0%}",
    ]


def main() -> None:
    cameras = synthetic.rectilinear_cameras()
    worlds = [
        (camera, members(camera, np.random.default_rng((n, i))))
        for n in range(ROUNDS)
        for i, camera in enumerate(cameras)
    ]
    rows = []
    for name, drawn in (("as drawn", True), ("in its shape", False)):
        rows.append(row(name, [outcome(*world, drawn=drawn) for world in track(worlds, name, len(worlds))]))
    document.replace("contributors", document.table(HEADER, rows))


if __name__ == "__main__":
    main()
