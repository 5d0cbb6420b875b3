"""Least squares of a rig: one board pose for each moment, seen by cameras that do not move to each other.

The unknowns that all moments share are the intrinsics of the free cameras, one after the other, then the
poses rvec|tvec of cameras 1, 2, ... The points of one moment in all cameras are one row of padded arrays,
in which each camera has its own columns, its slots. So the solver of one camera also fits rigs.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import models, rotation
from ..arrays import Array, Mask
from ..camera import Camera
from ..fitting import prior
from ..fitting.levenberg_marquardt import LeastSquares
from ..fitting.normal_equations import POSE_SIZE, Poses
from ..fitting.observations import Observations
from ..fitting.systematic_effects import row_position
from ..models import Model
from ..view import View

Moment = Mapping[int, View]
"""Views of one still board pose, by the positions of their cameras."""


def unlinked_cameras(count: int, moments: Sequence[Iterable[int]]) -> tuple[int, ...]:
    """Positions of `count` cameras to which no chain of shared moments leads from camera 0.

    A moment is given by the positions of the cameras that have a view of it.
    """
    reached = {0}
    for _ in range(count):
        for moment in moments:
            if not reached.isdisjoint(moment):
                reached.update(moment)
    return tuple(i for i in range(count) if i not in reached)


@dataclass(frozen=True, eq=False)
class RigMember:
    """Camera of a rig as the solver sees it.

    `held`: intrinsics (p,), None if they are fitted. `slots`: columns of its points. `weight`: noise of
    the rig / noise of this camera, by which its residuals are multiplied.
    """

    model: Model
    img_size: tuple[int, int]
    held: Array | None
    slots: slice
    weight: float = 1.0

    @property
    def free_size(self) -> int:
        """Number of intrinsics that are fitted."""
        return 0 if self.held is not None else self.model.size

    def fill_jacobian(self, k: Array, p: Array, by_k: Array, by_p: Array) -> Array:
        """Pixels as of `Model.fill_jacobian`; the derivatives that are filled in are weighted."""
        q = self.model.fill_jacobian(k, p, by_k, by_p)
        if self.weight != 1:
            by_k *= self.weight
            by_p *= self.weight
        return q


@dataclass(frozen=True, eq=False)
class RigProblem(LeastSquares):
    """Cameras of a rig to be fitted to moments, whose points each camera has in its slots of `obs`."""

    members: tuple[RigMember, ...]
    obs: Observations

    @classmethod
    def of(
        cls,
        moments: Sequence[Moment],
        cameras: Sequence[Camera],
        held: Sequence[bool],
        weights: Sequence[float] | None = None,
    ) -> "RigProblem":
        """Problem of `cameras` by position; intrinsics of those `held` are known."""
        lengths = [max((len(m[i]) for m in moments if i in m), default=0) for i in range(len(cameras))]
        ends = np.cumsum([0, *lengths]).tolist()
        members = tuple(
            RigMember(
                models.get(camera.model),
                camera.img_size,
                camera.intrinsics if held[i] else None,
                slice(ends[i], ends[i + 1]),
                weights[i] if weights else 1.0,
            )
            for i, camera in enumerate(cameras)
        )
        count = len(moments)
        points, pixels = np.zeros((count, 3, ends[-1])), np.zeros((count, 2, ends[-1]))
        mask: Mask = np.zeros((count, ends[-1]), dtype=bool)
        for m, moment in enumerate(moments):
            points[m] = next(iter(moment.values())).object_points[0][:, None]
            for position, view in moment.items():
                part = slice(ends[position], ends[position] + len(view))
                points[m, :, part], pixels[m, :, part] = view.object_points.T, view.image_points.T
                mask[m, part] = True
        return cls(members, Observations(points, pixels, mask))

    @property
    def width(self) -> int:
        """Width of the widest image, px."""
        return max(member.img_size[0] for member in self.members)

    @cached_property
    def offsets(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Places of each camera's intrinsics and of its pose among the shared unknowns; camera 0 has none."""
        sizes = [member.free_size for member in self.members]
        total, count = sum(sizes), len(sizes)
        first = tuple(int(n) for n in np.cumsum([0, *sizes])[:-1])
        return first, (-1, *(total + POSE_SIZE * i for i in range(count - 1)))

    @cached_property
    def row_positions(self) -> Array:
        """Rows (m, n) of the points, as `row_position`."""
        out = np.zeros(self.obs.mask.shape)
        for member in self.members:
            part = member.slots
            out[:, part] = row_position(self.obs.pixels[:, 1, part], member.img_size[1])
        return out

    @property
    def size(self) -> int:
        """Number of shared unknowns, p."""
        return sum(member.free_size for member in self.members) + POSE_SIZE * (len(self.members) - 1)

    def pack(self, intrinsics: Sequence[Array], poses: Array) -> Array:
        """Shared unknowns (p,) of the cameras' intrinsics and of their poses (c, 6)."""
        free = [k for k, member in zip(intrinsics, self.members, strict=True) if member.held is None]
        return np.concatenate([*free, poses[1:].reshape(-1)])

    def intrinsics(self, k: Array, position: int) -> Array:
        """Intrinsics of one camera at shared unknowns k (p,)."""
        member, start = self.members[position], self.offsets[0][position]
        return k[start : start + member.model.size] if member.held is None else member.held

    def camera_poses(self, k: Array) -> Array:
        """Poses (c, 6) rvec|tvec, camera 0 -> camera i."""
        count = POSE_SIZE * (len(self.members) - 1)
        tail = k[len(k) - count :].reshape(-1, POSE_SIZE)
        return np.concatenate([np.zeros((1, POSE_SIZE)), tail])

    def camera(self, k: Array, position: int) -> Camera:
        """One camera at shared unknowns k (p,)."""
        member = self.members[position]
        return Camera.from_intrinsics(member.model.name, self.intrinsics(k, position), member.img_size)

    def points_before_cameras(self, k: Array, poses: Poses, obs: Observations) -> Iterator[Array]:
        """Points (m, 3, n) of each camera's slots, in its frame."""
        in_rig = poses.camera_points(obs.points)
        for vector, member in zip(self.camera_poses(k), self.members, strict=True):
            yield rotation.matrix(vector[:3]) @ in_rig[:, :, member.slots] + vector[3:, None]

    def seen_by(self, mask: Mask) -> Mask:
        """True (m, c) if a camera has points of `mask` (m, n) in a moment."""
        return np.stack([mask[:, member.slots].any(axis=1) for member in self.members], axis=1)

    def is_feasible(self, k: Array) -> bool:
        """True if every camera has an image with the shared unknowns k (p,)."""
        every = [(member.model, self.intrinsics(k, i)) for i, member in enumerate(self.members)]
        return all(x[0] > 0 and x[1] > 0 and model.magnification(x[4:])[0] > 0 for model, x in every)

    def rows_of(self, k: Array, poses: Poses, obs: Observations, before: int = 0) -> tuple[Array, Array]:
        """Rows of a `State` at shared unknowns (p,) and board poses, board -> camera 0."""
        mask, size = obs.mask, before + self.size
        rows = np.empty((size + POSE_SIZE + 1, 2, *mask.shape))
        rotated = np.empty((3, *mask.shape))
        np.matmul(poses.r, obs.points, out=rotated.transpose(1, 0, 2))
        in_rig = rotated + poses.t.T[:, :, None]
        vectors = self.camera_poses(k)
        for i, member in enumerate(self.members):
            # Contiguous scratch arrays, copied to the camera's slots.
            mine, pixels = rows[:, :, :, member.slots], obs.pixels[:, :, member.slots]
            mine[before:size] = 0
            points, at_board = in_rig[:, :, member.slots], rotated[:, :, member.slots]
            by_k = np.empty((member.model.size, 2, *points.shape[1:]))
            by_p = np.empty((3, *by_k.shape[1:]))
            if i:
                r, t = rotation.matrix(vectors[i, :3]), vectors[i, 3:]
                turned = (r @ points.reshape(3, -1)).reshape(points.shape)
                q = member.fill_jacobian(self.intrinsics(k, i), turned + t[:, None, None], by_k, by_p)
                first = before + self.offsets[1][i]
                by_turn = cross(turned, by_p).reshape(3, -1)
                mine[first : first + 3] = (left_jacobian(vectors[i, :3]).T @ by_turn).reshape(by_p.shape)
                mine[first + 3 : first + 6] = by_p
                by_p = (r.T @ by_p.reshape(3, -1)).reshape(by_p.shape)
            else:  # the frame of the rig is this camera's
                q = member.fill_jacobian(self.intrinsics(k, i), points, by_k, by_p)
            if member.held is None:
                mine[before + self.offsets[0][i] :][: member.model.size] = by_k
            mine[size : size + 3] = cross(at_board, by_p)
            mine[size + 3 : size + 6] = by_p
            np.subtract(q, pixels.transpose(1, 0, 2), out=mine[-1])
            mine[-1] *= member.weight
        if not mask.all():
            rows[before:] = np.where(mask, rows[before:], 0.0)
        return rows, rows[-1, 0] ** 2 + rows[-1, 1] ** 2

    def residuals_of(self, k: Array, poses: Poses, obs: Observations) -> Array:
        """Weighted residuals (2, m, n), px, at shared unknowns (p,) and board poses."""
        out = np.empty((2, *obs.mask.shape))
        for i, p in enumerate(self.points_before_cameras(k, poses, obs)):
            member, part = self.members[i], self.members[i].slots
            q = member.model.project(self.intrinsics(k, i), p.transpose(1, 0, 2))
            out[:, :, part] = (q - obs.pixels[:, :, part].transpose(1, 0, 2)) * member.weight
        return np.where(obs.mask, out, 0.0)

    def prior_information(self, k: Array) -> Array:
        """Information (p, p) of the prior of the free intrinsics."""
        _, j = self.prior(k)
        return np.asarray(j.T @ j)

    def prior(self, k: Array) -> tuple[Array, Array]:
        """Whitened residuals (m,) of the prior of the free intrinsics, and their Jacobian (m, p)."""
        residuals, jacobians = [np.zeros(0)], [np.zeros((0, self.size))]
        for i, member in enumerate(self.members):
            if member.held is None:
                r, j = prior.residuals(member.model, self.intrinsics(k, i), member.img_size)
                wide = np.zeros((len(r), self.size))
                wide[:, self.offsets[0][i] : self.offsets[0][i] + member.model.size] = j
                residuals.append(r)
                jacobians.append(wide)
        return np.concatenate(residuals), np.concatenate(jacobians)


def left_jacobian(rvec: Array) -> Array:
    """Left Jacobian J (3, 3) of a rotation vector: matrix(r + d) = matrix(J d) matrix(r) to first order."""
    angle2 = float(rvec @ rvec)
    angle = np.sqrt(angle2)
    k = rotation.skew(rvec)
    if angle < 1e-4:
        return np.asarray(np.eye(3) + k / 2 + k @ k / 6)
    a, b = (1 - np.cos(angle)) / angle2, (angle - np.sin(angle)) / (angle2 * angle)
    return np.asarray(np.eye(3) + a * k + b * (k @ k))


def cross(p: Array, b: Array) -> Array:
    """Products p x b (3, 2, ...) of points (3, ...) and derivatives by a point (3, 2, ...).

    A small turn w of the point changes it by w x p, and b . (w x p) = w . (p x b).
    """
    x, y, z = p
    bx, by, bz = b
    product: Array = np.empty_like(b)
    np.multiply(y, bz, out=product[0])
    product[0] -= z * by
    np.multiply(z, bx, out=product[1])
    product[1] -= x * bz
    np.multiply(x, by, out=product[2])
    product[2] -= y * bx
    return product


MAX_ONLINE_POINTS = 16_000
"""Maximum points of a rig's fit during a request: about a second for eight cameras."""
MIN_KEPT_POINTS = 16
GOLDEN_RATIO = (np.sqrt(5) - 1) / 2


def thin(moments: Sequence[Moment], max_points: int) -> list[Moment]:
    """Moments of about `max_points`: views have equally many at most, but MIN_KEPT_POINTS at least.

    The solver's arrays have a column for each corner of the fullest view of each camera, in every moment.
    """
    count = len(moments) * len({position for moment in moments for position in moment})
    share = max(max_points // max(count, 1), MIN_KEPT_POINTS)
    return [{i: thin_view(view, share) for i, view in moment.items()} for moment in moments]


def thin_view(view: View, count: int) -> View:
    """View with `count` of its points, from all over it; itself if it has no more.

    They are even by a golden-ratio sequence, where equal steps may meet the same column in every row.
    """
    if len(view) <= count:
        return view
    order = np.argsort(np.arange(1, len(view) + 1) * GOLDEN_RATIO % 1.0)
    kept = np.sort(np.argsort(order, kind="stable")[:count])
    return view.subset(kept)
