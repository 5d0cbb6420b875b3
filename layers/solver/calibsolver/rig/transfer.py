"""Transfer of points between the cameras of a rig, its derivatives, and the predicted error.

A pixel of camera i becomes the point at working distance along its ray, and a pixel of camera j. This
error is free of what intrinsics and poses exchange between them: a turn of a camera's frame that its pose
makes good.
"""

import numpy as np

from .. import rotation
from ..arrays import Array, Mask
from ..camera import pixel_grid
from ..fitting import normal_equations
from ..fitting.levenberg_marquardt import State
from ..fitting.uncertainty import variance
from ..models import Model
from .calibration import RigUncertainty
from .problem import RigProblem, cross, left_jacobian

GRID = (12, 9)
MIN_SHARED = 3


def working_distances(problem: RigProblem, state: State, good: Mask) -> Array:
    """Median distance (c,), board units, of each camera from points that it and another camera saw."""
    shared = problem.seen_by(good).sum(axis=1) > 1
    out = np.full(len(problem.members), np.nan)
    for i, p in enumerate(problem.points_before_cameras(state.k, state.poses, problem.obs)):
        distances = np.linalg.norm(p, axis=1)[good[:, problem.members[i].slots] & shared[:, None]]
        if distances.size:
            out[i] = np.median(distances)
    return np.where(np.isfinite(out), out, np.nanmedian(out))


def jacobian(problem: RigProblem, k: Array, distances: Array) -> Array:
    """Derivatives (n, 2, p) of transferred pixels by the shared unknowns, of all ordered pairs of cameras.

    The pixels are those on a grid that land in the other image. If no two cameras share any: directions to
    the points from the other camera, times that camera's focal length.
    """
    count = len(problem.members)
    pairs = [(i, j) for i in range(count) for j in range(count) if i != j]
    shared = [_pair(problem, k, i, j, float(distances[i]), inside=True) for i, j in pairs]
    shared = [part for part in shared if len(part) >= MIN_SHARED]
    if not shared:
        shared = [_pair(problem, k, i, j, float(distances[i]), inside=False) for i, j in pairs]
    return np.concatenate(shared)


def metric(jacobian: Array, rows: Array, used: Mask) -> Array:
    """Metric W (p, p): trace(covariance W) is the mean square error of transfer, px^2."""
    flat = jacobian.reshape(-1, jacobian.shape[2])
    if not flat.size:
        return normal_equations.reduced_information(rows[:-1] * used)
    return np.asarray(flat.T @ flat / len(jacobian))


def uncertainty(
    problem: RigProblem, k: Array, jacobian: Array, covariance: Array, distances: Array
) -> RigUncertainty:
    """Predicted error of a rig whose shared unknowns have a covariance (p, p)."""
    turns, shifts = [], []
    for i, pose in enumerate(problem.camera_poses(k)[1:], start=1):
        part = slice(problem.offsets[1][i], problem.offsets[1][i] + 6)
        block = covariance[part, part]
        turn = left_jacobian(pose[:3])
        turns.append(float(np.sqrt(np.trace(turn @ block[:3, :3] @ turn.T))))
        # Of cameras in one place a distance says nothing: then the working distance is the measure.
        baseline = max(float(np.linalg.norm(pose[3:])), 1e-3 * float(distances[0]))
        shifts.append(float(np.sqrt(np.trace(block[3:, 3:]))) / baseline)
    mean = float(np.mean(variance(jacobian, covariance))) if len(jacobian) else np.inf
    return RigUncertainty(float(np.degrees(max(turns))), 100 * max(shifts), float(np.sqrt(mean)))


def _pair(problem: RigProblem, k: Array, i: int, j: int, distance: float, *, inside: bool) -> Array:
    """Derivatives (n, 2, p) of the transfer of pixels from camera i to camera j by the shared unknowns."""
    one, other = problem.members[i], problem.members[j]
    vectors = problem.camera_poses(k)
    k_i, k_j = problem.intrinsics(k, i), problem.intrinsics(k, j)
    r_i, r_j = rotation.matrix(vectors[i, :3]), rotation.matrix(vectors[j, :3])
    rays = one.model.unproject(k_i, pixel_grid(one.img_size, GRID).reshape(2, -1))
    rays = rays[:, np.isfinite(rays).all(axis=0)]
    x_i = distance * rays
    turned = r_j @ (r_i.T @ (x_i - vectors[i, 3:, None]))
    x_j = turned + vectors[j, 3:, None]
    if inside:
        q = other.model.project(k_j, x_j)
        w, h = other.img_size
        visible = other.model.valid(k_j[4:], x_j) & (q[0] > 0) & (q[1] > 0) & (q[0] < w - 1) & (q[1] < h - 1)
        rays, x_i, turned, x_j = (a[:, visible] for a in (rays, x_i, turned, x_j))
        _, by_kj, by_xj = other.model.jacobian(k_j, x_j)
    else:
        by_kj, by_xj = np.zeros((other.model.size, 2, x_j.shape[1])), _by_direction(x_j)
        by_xj *= float(other.model.focal(k_j)[0])
    by_xi = np.tensordot(r_i @ r_j.T, by_xj, 1)
    out = np.zeros((problem.size, 2, x_j.shape[1]))
    if other.held is None:
        out[problem.offsets[0][j] :][: other.model.size] = by_kj
    if one.held is None:
        by_ray = np.einsum("can,ncp->pan", by_xi * distance, _ray_derivatives(one.model, k_i, rays))
        out[problem.offsets[0][i] :][: one.model.size] += by_ray
    if j:
        at = problem.offsets[1][j]
        out[at : at + 3] = np.tensordot(left_jacobian(vectors[j, :3]).T, cross(turned, by_xj), 1)
        out[at + 3 : at + 6] = by_xj
    if i:
        at = problem.offsets[1][i]
        turn = cross(x_i - vectors[i, 3:, None], by_xi)
        out[at : at + 3] = -np.tensordot(left_jacobian(vectors[i, :3]).T, turn, 1)
        out[at + 3 : at + 6] = -by_xi
    d = out.transpose(2, 1, 0)
    return d[np.isfinite(d).all(axis=(1, 2))]


def _ray_derivatives(model: Model, k: Array, rays: Array) -> Array:
    """Derivatives (n, 3, p) of the unit rays (3, n) of fixed pixels by the intrinsics k (p,)."""
    _, by_k, by_p = model.jacobian(k, rays)
    a = by_p.transpose(2, 1, 0)
    inverse = a.transpose(0, 2, 1) @ np.linalg.inv(a @ a.transpose(0, 2, 1))
    return np.asarray(-inverse @ by_k.transpose(2, 1, 0))


def _by_direction(x: Array) -> Array:
    """Derivatives (3, 2, n) of two angles, radians, of the direction to points (3, n) by the points."""
    length = np.linalg.norm(x, axis=0)
    axes = rotation.rotation_to_ray((x / length).T)[:, :, :2]  # (n, 3, 2)
    return np.asarray(axes.transpose(1, 2, 0) / length)
