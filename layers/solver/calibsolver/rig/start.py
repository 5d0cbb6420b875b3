"""Start of a rig's fit: relative poses of the cameras by robust averaging over moments.

One view may show the board turned: a plain chessboard looks the same after half a turn, a square one after
a quarter, and a detector numbers its corners from whichever corner comes first. So each moment's relative
pose is a hypothesis. The one that explains the other moments best, their views turned if that explains
them better, is averaged with those that agree (as RANSAC; the chordal mean of rotations: Hartley et al.,
"Rotation averaging", 2013). A maximum spanning tree of shared moments leads from camera 0 to all the
others.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .. import models, rotation
from ..arrays import Array, IntArray
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import Approximation, approximate, fit
from ..fitting.observations import Observations
from ..fitting.resection import resect
from ..fitting.validation import MIN_POINTS, check
from ..view import View
from .problem import Moment

MAX_HYPOTHESES = 40
MAX_POINTS_AT_ONCE = 2**15
"""Points of one batch of hypotheses: more do not fit a cache."""
MAX_START_ERROR_WIDTHS = 0.04
"""Distance / image width from which it does not matter how far away points are."""
MIN_TURN_GAIN = 3.0
"""Error of a view as it came / error of it turned, from which it is taken as turned."""
SQUARE_RATIO = 1e-3
"""Relative difference of a board's sides below which it counts as square."""


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """Rotation (3, 3) and translation (3,): x -> r x + t."""

    r: Array
    t: Array

    @classmethod
    def of_vector(cls, rt: Array) -> "RigidMotion":
        """Motion of (6,) rvec|tvec."""
        return cls(rotation.matrix(rt[:3]), np.asarray(rt[3:], dtype=np.float64))

    def vector(self) -> Array:
        """(6,) rvec|tvec."""
        return np.concatenate([rotation.vector(self.r), self.t])

    def __matmul__(self, other: "RigidMotion") -> "RigidMotion":
        return RigidMotion(self.r @ other.r, self.r @ other.t + self.t)

    def inverse(self) -> "RigidMotion":
        """Motion back."""
        return RigidMotion(self.r.T, -self.r.T @ self.t)

    def __call__(self, points: Array) -> Array:
        """Points (n, 3) after the motion."""
        return np.asarray(points @ self.r.T + self.t)


@dataclass(frozen=True, eq=False)
class ResectedMoment:
    """Moment's views, and motions board -> camera by position."""

    views: Moment
    poses: Mapping[int, RigidMotion]


@dataclass(frozen=True, eq=False)
class LocatedMoment:
    """Moment: motion board -> camera 0, views turned back, and the positions of those that were turned."""

    board: RigidMotion
    views: Moment
    turned: tuple[int, ...]


def start(
    cameras: Sequence[Camera], moments: Sequence[ResectedMoment]
) -> tuple[list[RigidMotion], list[LocatedMoment]]:
    """Motions camera 0 -> each of `cameras`, which are nearly known, and where the board is in each moment.

    Raises CalibrationError ``unlinked``.
    """
    turns = symmetries([view for moment in moments for view in moment.views.values()])
    links = Counter(pair for moment in moments for pair in combinations(sorted(moment.poses), 2))
    to_rig = {0: RigidMotion(np.eye(3), np.zeros(3))}
    while len(to_rig) < len(cameras):
        reachable = {pair: n for pair, n in links.items() if (pair[0] in to_rig) != (pair[1] in to_rig)}
        if not reachable:
            lost = ", ".join(str(i) for i in range(len(cameras)) if i not in to_rig)
            raise CalibrationError(
                "unlinked",
                f"camera {lost} never sees the board together with another camera that camera 0 is linked to",
            )
        pair = max(reachable, key=lambda each: (reachable[each], (-each[0], -each[1])))
        placed, new = pair if pair[0] in to_rig else pair[::-1]
        to_rig[new] = _relative_pose(cameras, placed, new, moments, turns) @ to_rig[placed]
    motions = [to_rig[i] for i in range(len(cameras))]
    return motions, locate_boards(cameras, motions, moments, turns)


def symmetries(views: Sequence[View]) -> tuple[RigidMotion, ...]:
    """Turns of the board about its middle that leave its lattice the same, the identity first."""
    points = np.concatenate([view.object_points for view in views])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, (width, height, _) = (low + high) / 2, high - low
    quarters = (0, 1, 2, 3) if abs(width - height) < SQUARE_RATIO * max(width, height) else (0, 2)
    turns = []
    for quarter in quarters:
        r = np.round(rotation.matrix(np.array([0.0, 0.0, quarter * np.pi / 2])))
        turns.append(RigidMotion(r, middle - r @ middle))
    return tuple(turns)


def stack(motions: Sequence[RigidMotion]) -> tuple[Array, Array]:
    """Rotations (n, 3, 3) and translations (n, 3) of motions."""
    return np.stack([each.r for each in motions]), np.stack([each.t for each in motions])


def turn_back(view: View, turn: RigidMotion) -> View:
    """View of the board turned: each pixel belongs to the point to which the turn leads."""
    return replace(view, object_points=turn(view.object_points))


@dataclass(frozen=True, eq=False)
class _PaddedViews:
    """Views of one camera: points (s, m, 3, n) under each turn, pixels (m, 2, n), NaN where there is none."""

    camera: Camera
    points: Array
    pixels: Array

    @classmethod
    def of(cls, camera: Camera, views: Sequence[View], turns: Sequence[RigidMotion]) -> "_PaddedViews":
        obs = Observations.of(views)
        pixels = np.where(obs.mask[:, None], obs.pixels, np.nan)
        turned = [turn.r @ obs.points + turn.t[:, None] for turn in turns]
        return cls(camera, np.stack(turned), pixels)

    def errors(self, r: Array, t: Array) -> tuple[Array, IntArray]:
        """Median distances (..., m), px, of views from their predictions, and the turns with these distances.

        Infinite if half of the points cannot be seen. Boards r (..., m, 3, 3), t (..., m, 3) are in the
        camera frame.
        """
        model, k = models.get(self.camera.model), self.camera.intrinsics
        p = r[..., None, :, :, :] @ self.points + t[..., None, :, :, None]
        p = np.moveaxis(p, -2, 0)
        projected = model.project(k, p)
        dx, dy = projected[0] - self.pixels[:, 0], projected[1] - self.pixels[:, 1]
        distance = dx * dx + dy * dy
        distance = np.where(np.isfinite(distance) & model.valid(k[4:], p), distance, np.inf)
        middle = np.isfinite(self.pixels[:, 0]).sum(axis=1) // 2
        distance = np.partition(distance, np.unique(middle), axis=-1)
        medians = np.sqrt(distance[..., np.arange(len(middle)), middle])
        plain = medians[..., 0, :]
        best, errors = np.argmin(medians, axis=-2), medians.min(axis=-2)
        best[~(errors * MIN_TURN_GAIN < plain)] = 0
        return np.where(best > 0, errors, plain), best


def _relative_pose(
    cameras: Sequence[Camera],
    one: int,
    other: int,
    moments: Sequence[ResectedMoment],
    turns: Sequence[RigidMotion],
) -> RigidMotion:
    """Pose camera `one` -> camera `other` on which most of their shared moments agree."""
    shared = [moment for moment in moments if one in moment.poses and other in moment.poses]
    padded = _PaddedViews.of(cameras[other], [moment.views[other] for moment in shared], turns)
    width = cameras[other].img_size[0]
    r, t = stack([moment.poses[one] for moment in shared])
    tried = []
    hypotheses = shared[:: -(-len(shared) // MAX_HYPOTHESES)]
    step = max(1, MAX_POINTS_AT_ONCE // padded.points[:, :, 0].size)
    for batch in (hypotheses[i : i + step] for i in range(0, len(hypotheses), step)):
        relatives = [each.poses[other] @ each.poses[one].inverse() for each in batch]
        r_h, t_h = stack(relatives)
        r_h = r_h[:, None]
        errors, turned = padded.errors(r_h @ r, (r_h @ t[:, :, None])[..., 0] + t_h[:, None])
        costs = np.minimum(errors, MAX_START_ERROR_WIDTHS * width).sum(axis=1)
        tried += list(zip(costs.tolist(), relatives, errors, turned, strict=True))
    _, relative, errors, turned = min(tried, key=lambda each: each[0])
    near = max(2 * float(np.median(errors)), 1e-3 * width)
    agreed = [
        moment.poses[other] @ turns[turn].inverse() @ moment.poses[one].inverse()
        for moment, turn, error in zip(shared, turned.tolist(), errors.tolist(), strict=True)
        if error <= near
    ]
    if not agreed:
        return relative
    r = rotation.nearest(np.sum([each.r for each in agreed], axis=0))
    return RigidMotion(r, np.median([each.t for each in agreed], axis=0))


def locate_boards(
    cameras: Sequence[Camera],
    motions: Sequence[RigidMotion],
    moments: Sequence[ResectedMoment],
    turns: Sequence[RigidMotion],
) -> list[LocatedMoment]:
    """Find where the board is in each moment, and which views number it from another side.

    The view with which most of the others agree decides, then the fewest turns. Of two views either of
    which may be turned, the one that shows the board upright is as it should be.
    """
    hypotheses: list[list[tuple[tuple[float, ...], RigidMotion, dict[int, int]]]] = [[] for _ in moments]
    for reference in range(len(cameras)):
        with_pose = [m for m, moment in enumerate(moments) if reference in moment.poses]
        back = motions[reference].inverse()
        boards = {m: back @ moments[m].poses[reference] for m in with_pose}
        costs, labels = dict.fromkeys(with_pose, 0.0), {m: dict[int, int]() for m in with_pose}
        for position, camera in enumerate(cameras):
            shared = [m for m in with_pose if position in moments[m].views]
            if not shared:
                continue
            padded = _PaddedViews.of(camera, [moments[m].views[position] for m in shared], turns)
            errors, turned = padded.errors(*stack([motions[position] @ boards[m] for m in shared]))
            widths = (errors / camera.img_size[0]).tolist()
            for m, error, turn in zip(shared, widths, turned.tolist(), strict=True):
                costs[m] += min(error, MAX_START_ERROR_WIDTHS)
                if error < MAX_START_ERROR_WIDTHS:
                    labels[m][position] = turn
        for m in with_pose:
            turned_count = sum(turn > 0 for turn in labels[m].values())
            pose = moments[m].poses[reference]
            upright = pose.r[0, 0] + pose.r[1, 1]
            lean = -round(upright) if turned_count else 0
            rank = (-len(labels[m]), turned_count, lean, costs[m], reference)
            hypotheses[m].append((rank, boards[m], labels[m]))
    located = []
    for moment, each in zip(moments, hypotheses, strict=True):
        _, board, turned_by = min(each, key=lambda ranked: ranked[0])
        turned_positions = tuple(i for i, turn in turned_by.items() if turn)
        views = dict(moment.views)
        for i in turned_positions:
            views[i] = turn_back(views[i], turns[turned_by[i]])
        located.append(LocatedMoment(board, views, turned_positions))
    return located


Specification = Camera | tuple[tuple[int, int], str]
"""Camera whose intrinsics are held, or image size (width, height) in px and model to be fitted."""


@dataclass(frozen=True, eq=False)
class Single:
    """Single camera; poses and reasons by moment, noise in px."""

    camera: Camera
    is_held: bool
    poses: Mapping[int, RigidMotion]
    reasons: Mapping[int, str]
    noise: float


def fit_alone(
    moments: Sequence[Moment], position: int, given: Specification, robust: bool, near: Camera | None
) -> Single:
    """Fit, or resect, the views of one camera; CalibrationError names the camera."""
    numbers = [m for m, moment in enumerate(moments) if position in moment]
    views = [moments[m][position] for m in numbers]
    try:
        if isinstance(given, Camera):
            return _resect(given, numbers, views, robust)
        size, model = given
        result: Calibration | Approximation
        if robust:
            result = approximate(views, size, model, start=near)
        else:
            result = fit(views, size, model, robust=False, start=near)
    except CalibrationError as error:
        raise CalibrationError(error.code, f"camera {position}: {error.message}") from error
    poses = {
        m: RigidMotion.of_vector(result.poses[i]) for i, m in enumerate(numbers) if i not in result.cut_views
    }
    reasons = {numbers[i]: reason for i, reason in result.cut_views.items()}
    return Single(result.camera, False, poses, reasons, result.noise)


def resected(moments: Sequence[Moment], alone: Mapping[int, Single]) -> list[ResectedMoment]:
    """Moments with the poses that their cameras, fitted `alone`, have."""
    return [
        ResectedMoment(moment, {i: alone[i].poses[m] for i in moment if m in alone[i].poses})
        for m, moment in enumerate(moments)
    ]


def _resect(camera: Camera, numbers: Sequence[int], views: Sequence[View], robust: bool) -> Single:
    usable = [i for i, view in enumerate(views) if len(view) >= MIN_POINTS or not robust]
    if not usable:
        raise CalibrationError("too_few_points", f"every view needs {MIN_POINTS} points")
    obs = check([views[i] for i in usable], camera.img_size)
    poses, square = resect(models.get(camera.model), camera.intrinsics, obs)
    count = obs.mask.sum(axis=1)
    finite = np.isfinite(square)
    if not finite.any():
        raise CalibrationError("no_fit", "no view can be explained with the intrinsics given")
    spread = square[finite] / np.maximum(2 * count[finite] - 6, 1)
    found = {numbers[usable[i]]: RigidMotion(poses.r[i], poses.t[i]) for i in np.flatnonzero(finite).tolist()}
    refused = {m: "outlier" for m in numbers if m not in found}
    return Single(camera, True, found, refused, float(np.sqrt(np.median(spread))))
