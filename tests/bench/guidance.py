"""`make bench DOCS=guidance`: captures in the closed loop with every guidance.

`SEEDS=10` captures per camera and noise level; `ONLY=methods,conditions,hands,boards,bound`.
"""

import os
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib import pyplot

from calibsolver import Board, Camera
from calibsolver.arrays import symmetric_inverse
from calibsolver.capture import MAX_VIEWS
from calibsolver.fitting import prior
from calibsolver.guidance import IntrinsicsPosterior, ProjectionUncertainty, fixed_plan
from calibsolver.guidance.candidates import PoseLimits
from infra.console import announce
from tests.bench import document
from tests.helpers.data import ROOT
from tests.helpers.solver import hands, peers, populations, synthetic
from tests.helpers.solver.synthetic import Session, User

NOISES = (0.1, 0.2, 0.5)
VIEWS = (2, 3, 4, 6, 10)
CLUMSY = User(degrees=9.0, share=0.09)
Run = Callable[[Camera, np.random.Generator, float], Session]


def guided(views: int = 10, **world: object) -> Run:
    def run(camera: Camera, rng: np.random.Generator, noise: float) -> Session:
        return synthetic.run(camera, rng, noise=noise, views=views, max_views=MAX_VIEWS, **world)  # type: ignore[arg-type]

    return run


def planned(camera: Camera, rng: np.random.Generator, noise: float) -> Session:
    plan = synthetic.Planned(fixed_plan(Board(), camera.img_size, camera.model))
    return synthetic.run(camera, rng, noise=noise, views=10, max_views=MAX_VIEWS, guide=plan)


def comfortable(camera: Camera, rng: np.random.Generator, noise: float) -> Session:
    guide = peers.Comfortable(Board(), camera.img_size, camera.model)
    return synthetic.run(camera, rng, noise=noise, views=8, max_views=MAX_VIEWS, guide=guide)


def random(views: int, hand: hands.Hand = hands.STEADY) -> Run:
    return lambda camera, rng, noise: peers.random_poses(camera, rng, views, noise, hand)


METHODS: tuple[tuple[str, Run, bool], ...] = (
    ("projection-uncertainty", guided(), True),
    ("fixed plan", planned, True),
    ("pose-selection", peers.run_published_method, True),
    ("random poses", random(20), False),
    ("waving the board", lambda camera, rng, noise: peers.waving(camera, rng, 20, noise), False),
)
"""Ways to capture, and whether they end."""


def sessions(run: Run, cameras: Sequence[Camera], seeds: int, noise: float) -> list[Session]:
    return [
        run(camera, np.random.default_rng(100 * i + seed), noise)
        for i, camera in enumerate(cameras)
        for seed in range(seeds)
    ]


def pair(values: Sequence[float]) -> str:
    """Median / 95th percentile."""
    return f"{np.median(values):.2f}/{np.percentile(values, 95):.2f}" if len(values) else ""


def errors(found: Sequence[Session], views: int, of: str = "mean") -> list[float]:
    return [getattr(s, of)[views - 1] for s in found if len(s.mean) >= views]


def row(name: str, found: Sequence[Session], ends: bool = True) -> list[str]:
    tries = sum(s.attempts for s in found) / max(sum(len(s.views) for s in found), 1)
    figures = [*(pair(errors(found, n)) for n in VIEWS), f"{tries:.2f}"]
    if not ends:
        return [name, str(len(found)), "", "", *figures, "", ""]
    off = np.array(at_end(found, "rms")) > 2 * np.array(at_end(found, "predicted"))
    share = f"{100 * np.mean(off):.1f} %" if len(off) else ""
    never = str(sum(s.stopped is None for s in found))
    return [name, str(len(found)), stops(found), pair(at_end(found, "mean")), *figures, share, never]


def at_end(found: Sequence[Session], of: str) -> list[float]:
    return [getattr(s, of)[s.stopped - 1] for s in found if s.stopped]


def stops(found: Sequence[Session]) -> str:
    """Views at the end, median / 95th percentile."""
    counts = [s.stopped or 99 for s in found]
    return f"{np.median(counts):.0f}/{np.percentile(counts, 95):.0f}"


HEADER = [
    *("", "captures", "views at the end", "error at the end", *(f"{n} views" for n in VIEWS)),
    *("attempts per view", "error > 2 x predicted", "never ended"),
]


def methods(seeds: int) -> str:
    """Every method at every noise; plots the middle one."""
    cameras = synthetic.rectilinear_cameras()
    rows: list[list[str]] = []
    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    for name, run, ends in METHODS:
        for noise in NOISES:
            found = sessions(run, cameras, seeds, noise)
            rows.append(row(f"{name}, {noise} px", found, ends))
            if noise == 0.2:
                counts = [n for n in range(2, 11) if len(errors(found, n)) > 0.5 * len(found)]
                spread = [np.percentile(errors(found, n), [50, 95]) for n in counts]
                (line,) = axes.plot(counts, [s[0] for s in spread], label=name)
                axes.plot(counts, [s[1] for s in spread], "--", color=line.get_color())
    axes.set(xlabel="views", ylabel="mean projection error, px", yscale="log", ylim=(0.05, 10))
    axes.legend()
    figure.savefig(ROOT / "docs" / "images" / "guidance.svg")
    return document.table(HEADER, rows)


def conditions(seeds: int) -> str:
    straight = synthetic.rectilinear_cameras()
    harder: list[tuple[str, Run, Sequence[Camera]]] = [
        ("comfortable poses only", comfortable, straight),
        ("1 % of the corners 3 to 50 px off", guided(8, wild=0.01), straight),
        ("noise doubled at 45 degrees", guided(8, blur=1.0), straight),
        ("clumsy user: 9 degrees, 9 %", guided(8, user=CLUMSY), straight),
        ("fisheye, 118 to 166 degrees", guided(8), synthetic.fisheye_cameras()),
        ("rational, 75 to 125 degrees", guided(8), populations.rational_cameras()),
        ("omnidirectional, 120 to 190 degrees", guided(8), populations.omnidirectional_cameras()),
    ]
    return document.table(HEADER, [row(name, sessions(*world, seeds, 0.2)) for name, *world in harder])


def real_hands(seeds: int) -> str:
    """The default method and random poses in hands that move, with boards that bend, at 0.2 px."""
    cameras = synthetic.rectilinear_cameras()
    rows = []
    for name, hand in (
        ("rolling shutter of 20 ms, hand at 5 cm/s", hands.MOVING),
        ("board bent by 0.5 %", hands.BENT),
        ("both", hands.MOVING_AND_BENT),
    ):
        rows.append(row(name, sessions(guided(6, hand=hand), cameras, seeds, 0.2)))
        found = sessions(random(10, hand), cameras, seeds, 0.2)
        rows.append(row(f"{name}: random poses", found, ends=False))
    return document.table(HEADER, rows)


BOARDS = {
    "flat, noise 0.2 px": (0.2, hands.STEADY),
    "flat, motion 0.6 px": (0.3, hands.Hand(0.02, 1.2, 2.4)),
    "bent by 0.02 squares": (0.3, hands.Hand(sag_boards=0.02 / 9)),
    "bent by 0.02 squares, motion 0.6 px": (0.3, hands.Hand(0.02, 1.2, 2.4, 0.02 / 9)),
    "bent by 0.04 squares, motion 1 px": (0.3, hands.Hand(0.02, 2.0, 4.0, 0.04 / 9)),
}
"""Noise, px, and the hand; motion between the middle row and the rim."""
BOARD_VIEWS = 8
BOARDS_HEADER = [
    *("board", "captures", f"error after {BOARD_VIEWS} views", "stated", "within twice it"),
    *("views at the end", "error at the end"),
]


def boards(seeds: int) -> str:
    """The default method, errors as rms over the image, after BOARD_VIEWS views and at the end."""
    cameras, rows = synthetic.rectilinear_cameras(), []
    for name, (noise, hand) in BOARDS.items():
        found = sessions(guided(BOARD_VIEWS, hand=hand), cameras, seeds, noise)
        stated = [s.predicted[BOARD_VIEWS - 1] for s in found]
        actual = errors(found, BOARD_VIEWS, "rms")
        within = f"{np.mean(np.array(actual) <= 2 * np.array(stated)):.0%}"
        ends = stops(found), pair(at_end(found, "rms"))
        rows.append([name, str(len(found)), pair(actual), pair(stated), within, *ends])
    return document.table(BOARDS_HEADER, rows)


def limit(seeds: int) -> str:
    """Predicted error of captures and of the best views that could be found."""
    cameras = synthetic.rectilinear_cameras()
    best = np.median([bound(camera, VIEWS) for camera in cameras], axis=0)
    found = sessions(guided(), cameras, max(1, seeds // 3), 0.2)
    ours = [float(np.median([s.calibration_rms[n - 1] for s in found])) for n in VIEWS]
    rows = [
        ["best views, known camera", *(f"{b:.3f}" for b in best)],
        ["as captured", *(f"{o:.3f}" for o in ours)],
        ["ratio", *(f"{o / b:.2f}" for o, b in zip(ours, best, strict=True))],
    ]
    return document.table(["predicted rms, px (median camera)", *(f"{n} views" for n in VIEWS)], rows)


SWEEPS = 2


def bound(camera: Camera, counts: tuple[int, ...]) -> list[float]:
    """Predicted rms error over the image, px, of the best `counts` views found: greedy, then exchanged."""
    board = Board()
    guide = ProjectionUncertainty(board, camera.img_size, camera.model)
    model, k = guide.model, camera.intrinsics
    nothing = IntrinsicsPosterior(
        model, k, prior.information(model, k, camera.img_size), 0.2, camera.img_size
    )
    found: list[np.ndarray] = []
    out = []
    for count in counts:
        while len(found) < count:
            found.append(best_pose(guide, nothing, found, len(found)))
        for sweep in range(SWEEPS):
            for i in range(count):
                others = found[:i] + found[i + 1 :]
                other = best_pose(guide, nothing, others, count + sweep)
                if bound_error(nothing, [*others, other]) < bound_error(nothing, found):
                    found[i] = other
        out.append(bound_error(nothing, found))
    return out


def best_pose(
    guide: ProjectionUncertainty, nothing: IntrinsicsPosterior, found: list[np.ndarray], index: int
) -> np.ndarray:
    """Information (p, p) of the best pose in addition to others."""
    information = nothing.information + sum(found, np.zeros_like(nothing.information))
    posterior = IntrinsicsPosterior(nothing.model, nothing.k, information, nothing.noise, nothing.img_size)
    with np.errstate(all="ignore"):
        target = guide.choose(posterior, index, PoseLimits())
    after = guide.predict_posterior(posterior, target).information
    gained: np.ndarray = after - information
    return gained


def bound_error(nothing: IntrinsicsPosterior, found: list[np.ndarray]) -> float:
    covariance = symmetric_inverse(nothing.information + sum(found, np.zeros_like(nothing.information)))
    return float(np.sqrt(np.sum(covariance * nothing.error_metric)))


PARTS = {"methods": methods, "conditions": conditions, "hands": real_hands, "boards": boards, "bound": limit}


def main() -> None:
    seeds = int(os.environ.get("SEEDS", "10"))
    chosen = [part for part in PARTS.items() if document.is_chosen(part[0])]
    for name, part in announce(f"guidance {seeds}", chosen, lambda step: step[0]):
        document.replace(f"guidance {name}", part(seeds))


if __name__ == "__main__":
    main()
