"""Cameras whose calibrations are partly lies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibsolver import CalibrationError, Camera, View
from calibsolver.consensus import Consensus, Member, Rule, difference, pool
from tests.helpers.solver import populations, synthetic

RULE = Rule(min_contributors=3)
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
    """One camera: what is answered without the liars and with them, and how far the answer moved, px.

    `by_honest` is how far it moved with as many more honest ones in their place; None where nothing reliable
    was answered then, or nobody asked.
    """

    kind: str
    total: int
    clean: Consensus
    attacked: Consensus | None
    moved: float
    by_honest: float | None = None

    @property
    def reliable(self) -> bool:
        """True if there is a reliable answer in spite of the lies."""
        return self.attacked is not None and self.attacked.reliable

    @property
    def wrong(self) -> bool:
        """True if a reliable answer moved by more than half a pixel over the image."""
        return self.reliable and self.moved > MOVED


def trial(
    rng: np.random.Generator,
    kind: str,
    total: int,
    variation: float = 0.0,
    views: int = 5,
    others: np.random.Generator | None = None,
    effort: Effort | None = None,
    liars: int = 2,
) -> Trial:
    """Forty in a hundred of a camera's calibrations are lies, all from `liars` contributors.

    `variation` is the standard deviation of the focal lengths of honest specimens, as a share; that of the
    principal point is as many image widths. `others` makes as many honest contributors to compare
    the liars with.
    `effort`: what the attackers' views are like; None: like those of the others.
    """
    effort = effort or Effort(views)
    cameras = synthetic.rectilinear_cameras()
    camera = cameras[int(rng.integers(len(cameras)))]
    bad = int(0.4 * total)
    honest = [
        Member(f"h{i}", f"h{i}", tuple(populations.views(vary(camera, variation, rng), rng, count=views)))
        for i in range(total - bad)
    ]
    false = [
        Member(f"l{i}", f"l{i % liars}", seen)
        for i, seen in enumerate(lies(kind, camera, bad, variation, rng, effort))
    ]
    size = camera.img_size
    clean = pool(honest, size, "rectilinear", RULE)
    everybody = [*false, *honest]
    members = [everybody[i] for i in rng.permutation(total)]
    by_honest = None
    if others is not None:
        more = [
            Member(
                f"x{i}",
                f"x{i % liars}",
                tuple(populations.views(vary(camera, variation, others), others, count=views)),
            )
            for i in range(bad)
        ]
        unharmed = pool([*honest, *more], size, "rectilinear", RULE)
        by_honest = (
            difference(clean.calibration.camera, unharmed.calibration.camera) if unharmed.reliable else None
        )
    try:
        attacked = pool(members, size, "rectilinear", RULE)
    except CalibrationError:
        return Trial(kind, total, clean, None, 0.0, by_honest)
    moved = difference(clean.calibration.camera, attacked.calibration.camera)
    return Trial(kind, total, clean, attacked, moved, by_honest)


def vary(camera: Camera, variation: float, rng: np.random.Generator) -> Camera:
    """Another specimen of the same product."""
    k = camera.intrinsics
    k[:2] *= 1 + variation * rng.normal()
    k[2:4] += variation * camera.img_size[0] * rng.normal(size=2)
    return Camera.from_intrinsics(camera.model, k, camera.img_size)


def lies(
    kind: str, camera: Camera, count: int, variation: float, rng: np.random.Generator, effort: Effort
) -> Sequence[tuple[View, ...]]:
    """Views of the sessions of liars: from just beside the truth to far from it."""

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
