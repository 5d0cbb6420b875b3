"""`make bench DOCS=guidance`: captures in the closed loop with every guidance.

`SEEDS=10` captures per camera and noise level.
"""

import os
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib import pyplot

from calibsolver import Board, Camera
from calibsolver.capture import MAX_VIEWS
from calibsolver.guidance import fixed_plan
from tests.bench import document
from tests.helpers.data import ROOT
from tests.helpers.solver import peers, synthetic
from tests.helpers.solver.synthetic import Session

NOISES = (0.1, 0.2, 0.5)
VIEWS = (2, 3, 4, 6, 10)
Run = Callable[[Camera, np.random.Generator, float], Session]


def guided(camera: Camera, rng: np.random.Generator, noise: float) -> Session:
    return synthetic.run(camera, rng, noise=noise, views=10, max_views=MAX_VIEWS)


def planned(camera: Camera, rng: np.random.Generator, noise: float) -> Session:
    plan = synthetic.Planned(fixed_plan(Board(), camera.img_size, camera.model))
    return synthetic.run(camera, rng, noise=noise, views=10, max_views=MAX_VIEWS, guide=plan)


METHODS: tuple[tuple[str, Run, bool], ...] = (
    ("projection-uncertainty", guided, True),
    ("fixed plan", planned, True),
    ("pose-selection", peers.run_published_method, True),
    ("random poses", lambda camera, rng, noise: peers.random_poses(camera, rng, 20, noise), False),
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


def errors(found: Sequence[Session], views: int) -> list[float]:
    return [s.mean[views - 1] for s in found if len(s.mean) >= views]


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


def main() -> None:
    document.replace("guidance methods", methods(int(os.environ.get("SEEDS", "10"))))


if __name__ == "__main__":
    main()
