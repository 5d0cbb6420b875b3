"""What all calibrations of one camera agree on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import models, normal, rotation, start
from .arrays import Array, Mask, symmetric_inverse
from .calibration import Calibration
from .errors import CalibrationError
from .fit import fit
from .normal import Poses
from .observations import Observations
from .uncertainty import pixel_grid
from .view import View

GRID = (12, 9)


@dataclass(frozen=True, eq=False)
class Member:
    """One calibration of the camera: its id, who contributed it, its views."""

    id: str
    contributor: str
    views: tuple[View, ...]


@dataclass(frozen=True)
class Rule:
    """When a consensus is called reliable.

    Attributes
    ----------
    min_calibrations, min_contributors
        In the largest group that agrees.
    min_share
        Of all calibrations that this group holds.
    max_focal_spread
        Standard deviation of fx / fx, and of fy / fy, within the group.
    max_center_spread
        Standard deviation of cx / width, and of cy / height.
    max_projection_spread
        Two calibrations agree where their projections differ by less than this, rms over the image after
        the best rotation / image width.
    max_unexplained
        A member's views, its poses fitted to the others' intrinsics, may have an rms above that of its own
        fit by this / image width.
    """

    min_calibrations: int = 5
    min_contributors: int = 1
    min_share: float = 0.6
    max_focal_spread: float = 0.05
    max_center_spread: float = 0.02
    max_projection_spread: float = 0.01
    max_unexplained: float = 0.004


@dataclass(frozen=True, eq=False)
class Consensus:
    """The largest group of calibrations that agree.

    Attributes
    ----------
    calibration
        One set of intrinsics fitted to all views of the group.
    members
        Ids of the group, in the order given.
    contributors
        Number of different contributors in the group.
    reliable
        Whether the rule holds.
    total
        Number of all calibrations.
    """

    calibration: Calibration
    members: tuple[str, ...]
    contributors: int
    reliable: bool
    total: int


def pool(
    members: Sequence[Member], img_size: tuple[int, int], model: str, rule: Rule | None = None
) -> Consensus:
    """Pool the calibrations of one camera.

    Raises CalibrationError (``no_members``, or what `fit` raises) where nothing believable comes out.
    """
    rule = rule or Rule()
    fits: list[tuple[Member, Calibration]] = []
    failure = CalibrationError("no_members", "there is no calibration to pool")
    for member in members:
        try:
            fits.append((member, fit(member.views, img_size, model)))
        except CalibrationError as error:
            failure = error
    if not fits:
        raise failure
    differences = compare([c for _, c in fits])
    index = largest(differences < rule.max_projection_spread * img_size[0], differences)
    group = [fits[i] for i in index]
    pooled = fit([view for member, _ in group for view in member.views], img_size, model)
    contributors = len({member.contributor for member, _ in group})
    reliable = (
        len(group) >= rule.min_calibrations
        and contributors >= rule.min_contributors
        and len(group) >= rule.min_share * len(members)
        and spread_within(group, img_size, rule)
        and explained(group, pooled, rule)
    )
    return Consensus(pooled, tuple(m.id for m, _ in group), contributors, reliable, len(members))


def compare(calibrations: Sequence[Calibration]) -> Array:
    """Differences (c, c) between the projections of calibrations of one image size, px rms over the image.

    The rays of the same pixels, turned onto each other as well as can be (Kabsch 1976), and the remaining
    angles times the local magnification. Infinite where two share less than half of the image.
    """
    size = calibrations[0].camera.img_size
    q = pixel_grid(size, GRID).reshape(2, -1)
    rays, scale = [], []
    for c in calibrations:
        law, k = models.get(c.camera.model), c.camera.intrinsics
        v = law.unproject(k, q)
        with np.errstate(all="ignore"):
            _, _, by_p = law.jacobian(k, v)
            # Area magnification px^2 per steradian: the Jacobian is 0 along the ray.
            g = np.einsum("ian,ibn->nab", by_p, by_p)
            scale.append(np.sqrt(np.sqrt(np.maximum(np.linalg.det(g), 0))))
        rays.append(v.T)
    v, px = np.stack(rays), np.stack(scale)
    seen = np.isfinite(v[:, :, 0]) & np.isfinite(px)
    v, px = np.where(seen[:, :, None], v, 0.0), np.where(seen, px, 0.0)
    both = seen[:, None, :] & seen[None, :, :]
    count = both.sum(axis=2)
    m = np.einsum("anb,cnd->acbd", v, v)
    turn = rotation.nearest(m)  # v_a ~ turn v_c
    out = np.empty((len(v), len(v)))
    for a in range(len(v)):
        moved = np.einsum("cij,cnj->cni", turn[a], v)
        angle2 = np.sum((v[a] - moved) ** 2, axis=2)
        square = angle2 * (px[a] * px) * both[a]
        out[a] = np.sqrt(square.sum(axis=1) / np.maximum(count[a], 1))
    out[count < 0.5 * q.shape[1]] = np.inf
    np.fill_diagonal(out, 0.0)
    return out


def largest(agree: Mask, differences: Array) -> list[int]:
    """Find the largest group whose members all agree with one of them; the tightest of equals."""
    counts = agree.sum(axis=1)
    near = np.where(agree, differences, 0.0).sum(axis=1)
    center = min(range(len(counts)), key=lambda i: (-int(counts[i]), float(near[i])))
    return [int(i) for i in np.flatnonzero(agree[center])]


def spread_within(group: Sequence[tuple[Member, Calibration]], img_size: tuple[int, int], rule: Rule) -> bool:
    """Whether focal lengths and principal points vary no more than the rule allows."""
    k = np.stack([c.camera.intrinsics[:4] for _, c in group])
    std = k.std(axis=0)
    focal = std[:2] / k[:, :2].mean(axis=0)
    center = std[2:] / np.asarray(img_size)
    return bool((focal < rule.max_focal_spread).all() and (center < rule.max_center_spread).all())


def explained(group: Sequence[tuple[Member, Calibration]], pooled: Calibration, rule: Rule) -> bool:
    """Whether intrinsics fitted to the others explain each member's views, the poses alone fitted anew."""
    law = models.get(pooled.camera.model)
    allowed = rule.max_unexplained * pooled.camera.img_size[0]
    for (member, own), k in zip(group, without_each(group, pooled), strict=True):
        if held_out(law, k, member.views) > own.avg_reprojection_error + allowed:
            return False
    return True


def without_each(group: Sequence[tuple[Member, Calibration]], pooled: Calibration) -> list[Array]:
    """Intrinsics (p,) of the pooled fit without each of its members.

    One Gauss-Newton step away from the optimum of all: at it the reduced gradients of the views add up to
    nothing, so taking away a member leaves minus its own (Cook & Weisberg 1982, case deletion).
    """
    law, k = models.get(pooled.camera.model), pooled.camera.intrinsics
    obs = Observations.of([view for member, _ in group for view in member.views])
    q, j = normal.design(law, k, Poses.of_vectors(pooled.poses), obs.points)
    weights = np.zeros(obs.mask.shape)
    for row, used in zip(weights, pooled.used, strict=True):
        row[: len(used)] = used
    r = (q - obs.pixels)[:, None]
    h = normal.information(np.concatenate([r, j], axis=1), weights)
    total = h[:, 1:, 1:].sum(axis=0)
    out, first = [], 0
    for member, _ in group:
        own = h[first : first + len(member.views)].sum(axis=0)
        first += len(member.views)
        if len(group) == 1:
            out.append(k)
            continue
        out.append(k + symmetric_inverse(total - own[1:, 1:]) @ own[1:, 0])
    return out


def held_out(law: models.Model, k: Array, views: Sequence[View]) -> float:
    """Px rms of views under given intrinsics (p,), poses fitted by Gauss-Newton from the linear solution."""
    obs = Observations.of(views)
    weights = obs.mask.astype(np.float64)
    with np.errstate(all="ignore"):  # views that these intrinsics cannot explain run away: infinite rms
        poses = start.at(law, obs, k).poses
        best = np.inf
        for _ in range(10):
            q, j = normal.design(law, k, poses, obs.points)
            r = q - obs.pixels
            rms = float(np.sqrt(np.sum(r * r * weights[:, None]) / weights.sum()))
            if not rms < best * (1 - 1e-6):
                break
            best = rms
            b = (j[:, law.size :] * weights[:, None, None, :]).reshape(len(r), 6, -1)
            h = b @ b.transpose(0, 2, 1)
            g = np.einsum("vij,vj->vi", b, r.reshape(len(r), -1))
            scale = 1 / np.sqrt(np.maximum(np.diagonal(h, axis1=1, axis2=2), 1e-300))
            unit = h * scale[:, :, None] * scale[:, None, :] + 1e-12 * np.eye(6)
            if not np.isfinite(unit).all():
                break
            step = -scale * np.linalg.solve(unit, (scale * g)[:, :, None])[:, :, 0]
            poses = poses.moved(step)
    return best
