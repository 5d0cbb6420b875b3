"""Cameras whose calibrations are partly lies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibsolver import CalibrationError, Camera, View
from calibsolver.consensus import Consensus, Member, Rule, difference, pool
from tests.helpers.solver import populations, synthetic

HONEST_VIEWS = 5
MOVED = 0.5
"""px over the image, by which no lie may move a reliable answer."""
KINDS = ("focal", "shift", "each", "junk")
"""One wrong focal length; it and a wrong principal point and decentering; each its own; no camera at all."""


@dataclass(frozen=True)
class Effort:
    """Views of each calibration of an attacker, and the noise of their corners, px."""

    views: int
    noise: float = 0.2


EFFORTS = {"very poor views": Effort(3, 2.0), "very many views": Effort(60, 0.05)}


@dataclass(frozen=True)
class Trial:
    """One camera: its consensus without the liars and with them, and how far that moved, px.

    `by_honest` is how far it moved with calibrated contributors in their place; None if it was not reliable
    then, or not asked for.
    """

    clean: Consensus
    attacked: Consensus | None
    moved: float
    by_honest: float | None = None

    @property
    def reliable(self) -> bool:
        return self.attacked is not None and self.attacked.reliable

    @property
    def wrong(self) -> bool:
        """True if a reliable consensus moved by more than half a pixel over the image."""
        return self.reliable and self.moved > MOVED


def trial(
    rng: np.random.Generator,
    kind: str,
    total: int,
    variation: float = 0.0,
    others: np.random.Generator | None = None,
    effort: Effort | None = None,
    liars: int = 2,
) -> Trial:
    """Forty in a hundred of a camera's calibrations are lies, all from `liars` contributors.

    `variation` is the standard deviation of the specimens' focal lengths, as a share; that of the principal
    point is as many image widths. `others` draws calibrated contributors in the liars' place. `effort`: what
    the attackers' views are like; None: like those of the others.
    """
    cameras = synthetic.rectilinear_cameras()
    camera = cameras[int(rng.integers(len(cameras)))]
    bad = int(0.4 * total)

    def specimen(rng: np.random.Generator) -> tuple[View, ...]:
        return tuple(populations.views(vary(camera, variation, rng), rng, count=HONEST_VIEWS))

    def pooled(members: Sequence[Member]) -> Consensus:
        return pool(members, camera.img_size, "rectilinear", Rule(min_contributors=3))

    honest = [Member(f"h{i}", f"h{i}", specimen(rng)) for i in range(total - bad)]
    seen = lies(kind, camera, bad, variation, rng, effort or Effort(HONEST_VIEWS))
    everybody = [*(Member(f"l{i}", f"l{i % liars}", views) for i, views in enumerate(seen)), *honest]
    members = [everybody[i] for i in rng.permutation(total)]
    clean = pooled(honest)
    by_honest = None
    if others is not None:
        unharmed = pooled(
            [*honest, *(Member(f"x{i}", f"x{i % liars}", specimen(others)) for i in range(bad))]
        )
        if unharmed.reliable:
            by_honest = difference(clean.calibration.camera, unharmed.calibration.camera)
    try:
        attacked = pooled(members)
    except CalibrationError:
        return Trial(clean, None, 0.0, by_honest)
    moved = difference(clean.calibration.camera, attacked.calibration.camera)
    return Trial(clean, attacked, moved, by_honest)


def vary(camera: Camera, variation: float, rng: np.random.Generator) -> Camera:
    k = camera.intrinsics
    k[:2] *= 1 + variation * rng.normal()
    k[2:4] += variation * camera.img_size[0] * rng.normal(size=2)
    return Camera.from_intrinsics(camera.model, k, camera.img_size)


def lies(
    kind: str, camera: Camera, count: int, variation: float, rng: np.random.Generator, effort: Effort
) -> Sequence[tuple[View, ...]]:
    """Views of the sessions of liars, from close to the truth to far from it."""

    def wrong() -> Camera:
        k = camera.intrinsics
        size = np.exp(rng.uniform(np.log(0.002), np.log(0.3))) * rng.choice((-1, 1))
        k[:2] *= 1 + size
        if kind != "focal":
            k[2:4] += 0.3 * size * camera.img_size[0] * rng.normal(size=2)
            k[6:8] += 0.01 * size * rng.normal(size=2)
        return Camera.from_intrinsics(camera.model, k, camera.img_size)

    common = wrong()
    out = []
    for _ in range(count):
        source = wrong() if kind == "each" else vary(common, variation, rng)
        seen = populations.views(source, rng, effort.noise, effort.views)
        if kind == "junk":
            w, h = camera.img_size
            seen = [View(v.object_points, rng.uniform((0, 0), (w, h), (len(v), 2))) for v in seen]
        out.append(tuple(seen))
    return out
