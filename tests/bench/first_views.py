"""First guided view and length of captures that start from an estimate, against the flat guess; simulated.

`make bench DOCS=first-views`: 12 cameras, 6 seeds. The logarithm of an estimate's focal length is
wrong by a normal deviate: 0.03 for a published model, 0.15 for a kind of device.
"""

import statistics
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calibsolver import Board, Camera
from calibsolver.capture import Capture
from tests.helpers.solver import synthetic

SIGMAS = {"flat guess": None, "estimate, published": 0.03, "estimate, population": 0.15}
MAX_VIEWS = 15
UNENDED = MAX_VIEWS + 1  # views that a capture counts which does not end


@dataclass(frozen=True)
class Captures:
    """Captures of one start: share of accepted first views; mean views until the end, and refusals."""

    first: float
    views: float
    refused: float


def starting(camera: Camera, sigma: float, rng: np.random.Generator) -> Camera:
    """Camera of an estimate: a pinhole, its centre in the middle."""
    w, h = camera.img_size
    focal = camera.intrinsics[0] * np.exp(sigma * rng.normal())
    matrix = np.array([[focal, 0, (w - 1) / 2], [0, focal, (h - 1) / 2], [0, 0, 1]])
    return Camera(camera.model, matrix, np.zeros(len(camera.distortion)), camera.img_size)


def runs(sigma: float | None, seeds: int, **options: int) -> Iterator[synthetic.Session]:
    for index, camera in enumerate(synthetic.rectilinear_cameras()):
        for seed in range(seeds):
            own = np.random.default_rng([index, seed])
            start = None if sigma is None else starting(camera, sigma, own)
            capture = Capture(Board(), camera.img_size, camera.model, seed=start)
            rng = np.random.default_rng(100 * index + seed)
            yield synthetic.run(camera, rng, capture=capture, **options)


def first_accepted(sigma: float | None, seeds: int = 6) -> float:
    sessions = runs(sigma, seeds, views=1, max_attempts=1)
    return statistics.fmean(len(session.views) for session in sessions)


def measure(sigma: float | None) -> Captures:
    sessions = list(runs(sigma, 6, views=2, max_views=MAX_VIEWS))
    return Captures(
        first=first_accepted(sigma),
        views=statistics.fmean(session.stopped or UNENDED for session in sessions),
        refused=statistics.fmean(len(session.reasons) for session in sessions),
    )


def main() -> None:
    for name, sigma in SIGMAS.items():
        found = measure(sigma)
        first = f"first view accepted {100 * found.first:.0f} %"
        print(f"{name}: {first}, {found.views:.2f} views, {found.refused:.2f} refused")


if __name__ == "__main__":
    main()
