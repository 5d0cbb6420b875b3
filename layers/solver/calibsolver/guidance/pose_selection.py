"""Pose selection as published: one parameter at a time, until the last view of each helped little.

Rojtberg & Kuijper, "Efficient Pose Selection for Interactive Camera Calibration" (ISMAR 2018) and "User
Guidance for Interactive Camera Calibration" (2019): plain least squares after each view, the parameter
with the largest index of dispersion next, tilted views for the intrinsics, views of the most distorted
part of the image for the coefficients. It is a baseline for the default guidance.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import rotation
from ..arrays import Array, Mask
from ..board import Board
from ..camera import Camera, pixel_grid
from ..errors import CalibrationError, undetermined
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..fitting.homography import Homographies
from ..view import View
from .hints import Placement
from .target import Guide, TargetPose, edge_points

CELL_PX = 20
MASK_PX = 8
MIN_REGION_SHARE = 0.3
MIN_COVERED_SHARE = 0.9
"""Share of a region that earlier targets have covered, from which another region is sought."""


@dataclass(frozen=True)
class Box:
    """Rectangle of the image, as shares of its width and height."""

    left: float
    top: float
    width: float
    height: float


WHOLE_IMAGE = Box(0.0, 0.0, 1.0, 1.0)


def find_next_region(camera: Camera, covered: Sequence[Box]) -> Box:
    """Most distorted part of the image that is not yet `covered`; else the whole image.

    The threshold on |distorted - undistorted| falls from 95 % of its largest value in steps of 5 % until a
    connected region appears that is hardly covered.
    """
    w, h = camera.img_size
    columns, rows = max(w // CELL_PX, 2), max(h // CELL_PX, 2)
    strength = displacement(camera, columns, rows)
    covered_cells = np.zeros((rows, columns), dtype=bool)
    x, y = (np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows
    for box in covered:
        across = (x >= box.left) & (x <= box.left + box.width)
        down = (y >= box.top) & (y <= box.top + box.height)
        covered_cells |= down[:, None] & across[None]
    largest = strength.max()
    for percent in range(95, 0, -5):
        for region in connected_regions(strength >= percent / 100 * largest):
            if covered_cells[region].mean() < MIN_COVERED_SHARE:
                return bounding_box(region)
    return WHOLE_IMAGE


def connected_regions(mask: Mask) -> Iterator[Mask]:
    """Connected regions (8 neighbours) of a mask (rows, columns), from its top left."""
    left = {(int(y), int(x)) for y, x in np.argwhere(mask)}
    for first in sorted(left):
        if first not in left:
            continue
        region, reached = np.zeros_like(mask), [first]
        left.remove(first)
        while reached:
            y, x = reached.pop()
            region[y, x] = True
            near = {(y + dy, x + dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)} & left
            left -= near
            reached += near
        yield region


def displacement(camera: Camera, columns: int, rows: int) -> Array:
    """Displacement of pixels by the distortion, px, on a grid (rows, columns).

    It is relative to a pinhole camera of the same focal length. Pixels without a ray, or whose ray is
    nearly perpendicular to the axis, get the largest displacement of all others.
    """
    q = pixel_grid(camera.img_size, (columns, rows)).reshape(2, -1).T
    ray = camera.unproject(q)
    center = camera.intrinsics[2:4]
    with np.errstate(all="ignore"):
        pinhole = ray[:, :2] / ray[:, 2:] * camera.focal + center
        distance = np.linalg.norm(pinhole - q, axis=1)
    distance = np.where(ray[:, 2] > 0.05, distance, np.nan)
    largest = np.nanmax(distance) if np.isfinite(distance).any() else 1.0
    return np.asarray(np.nan_to_num(distance, nan=largest).reshape(rows, columns))


def bounding_box(region: Mask) -> Box:
    """Bounding box of a region (rows, columns), enlarged to MIN_REGION_SHARE of the image."""
    rows, columns = region.shape
    y, x = np.nonzero(region)
    left, right = x.min() / columns, (x.max() + 1) / columns
    top, bottom = y.min() / rows, (y.max() + 1) / rows
    width, height = max(right - left, MIN_REGION_SHARE), max(bottom - top, MIN_REGION_SHARE)
    left = float(np.clip((left + right - width) / 2, 0, 1 - width))
    top = float(np.clip((top + bottom - height) / 2, 0, 1 - height))
    return Box(left, top, float(width), float(height))


DISTANCE_LENGTHS = 1.6
"""Distance of tilted boards / their length, whatever the lens."""
TILT_RANGE_DEG = 70.0
SHIFT_SHARE = 0.05
"""Share of the image by which the board is moved for the principal point."""
MIN_OVERLAP = 0.85
"""Jaccard index from which a target is reached."""
CONVERGED_DECREASE = 0.10
"""Relative decrease of a standard deviation below which the parameter has converged."""
MIN_REACHED_CORNERS = 15
INITIAL_FOCAL_WIDTHS = 1000 / 1280
INTRINSICS = ("fx", "fy", "cx", "cy")


@dataclass(frozen=True, eq=False)
class Progress:
    """Progress of the method after some views; no next parameter: all have converged."""

    converged: frozenset[int]
    target_counts: tuple[int, ...]
    covered: tuple[Box, ...]
    calibration: Calibration | None
    next_parameter: int | None


class PoseSelection(Guide):
    """Guidance by the published method. `seed` is not used."""

    @cached_property
    def _steps(self) -> list[tuple[View, Progress]]:
        """Views that were replayed, and the progress after each."""
        return []

    @undetermined()
    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Next pose; a skipped pose is followed by the method's next one."""
        del calibration, unreached  # the method fits for itself, and learns nothing of its user
        step = (len(views) + len(skipped)) if len(views) < 2 else len(views)
        camera = self.camera(views)
        if step == 0:
            r = rotation.matrix(np.radians([0, 45.0, 0])) @ rotation.matrix(np.radians([0, 0, 22.5]))
            return self._target(r, self._place_on_axis(r), camera, "a first look")
        if step == 1 or not views:
            return self._fronto_parallel_target(WHOLE_IMAGE, camera, "to fill the picture")
        progress = self.progress(views)
        parameter = progress.next_parameter or 0
        if parameter < len(INTRINSICS):
            return self.tilted_target(parameter, progress.target_counts[parameter] + len(skipped), camera)
        purpose = f"to measure {self.model.coefficients[parameter - len(INTRINSICS)]}"
        return self._fronto_parallel_target(find_next_region(camera, progress.covered), camera, purpose)

    def tilted_target(self, parameter: int, times: int, camera: Camera) -> TargetPose:
        """Target for fx, fy, cx or cy, by its index, that has had `times` targets before."""
        # fx and cx are seen in a tilt about the upright axis, fy and cy in one about the other.
        axis = np.array([0.0, 1.0, 0.0]) if parameter % 2 == 0 else np.array([1.0, 0.0, 0.0])
        r = rotation.matrix(np.radians(subdivided_tilt_deg(times)) * axis)
        t = self._place_on_axis(r)
        if parameter >= 2:
            side = SHIFT_SHARE * (1 if times % 2 == 0 else -1)
            shift_px = side * np.array(self.img_size) * axis[[1, 0]]
            z = DISTANCE_LENGTHS * max(self.board.size)
            t = t + np.array([*(shift_px / camera.focal * z), 0.0])
        return self._target(r, t, camera, f"to measure {INTRINSICS[parameter]}")

    def is_reached(self, target: TargetPose, view: View) -> bool:
        """True if the board is at the target, and enough of it is visible."""
        if len(view) < min(MIN_REACHED_CORNERS, self.board.corner_count):
            return False
        return jaccard_index(target.outline, estimate_outline(self.board, view), self.img_size) > MIN_OVERLAP

    def is_done(self, views: Sequence[View]) -> bool:
        """True if every parameter has converged."""
        return len(views) >= 2 and self.progress(views).next_parameter is None

    def estimate(self, views: Sequence[View]) -> Calibration | None:
        """Plain least squares; None if that fails."""
        with suppress(CalibrationError):
            return fit(views, self.img_size, self.model.name, robust=False)
        return None

    def progress(self, views: Sequence[View]) -> Progress:
        """Progress after `views`; steps that were replayed before are cached."""
        count = 0
        while count < min(len(views), len(self._steps)) and self._steps[count][0] is views[count]:
            count += 1
        del self._steps[count:]
        for i in range(count, len(views)):
            last = self._steps[-1][1] if self._steps else None
            self._steps.append((views[i], self._advance(list(views[: i + 1]), last)))
        return self._steps[-1][1]

    def _advance(self, views: list[View], last: Progress | None) -> Progress:
        size = self.model.size
        calibration = self.estimate(views) if len(views) >= 2 else None
        if last is None or last.calibration is None or calibration is None:
            chosen = 0 if calibration is None else self._most_dispersed(calibration, frozenset())
            return Progress(frozenset(), (0,) * size, (), calibration, chosen)
        converged, counts, covered = set(last.converged), list(last.target_counts), last.covered
        if last.next_parameter is not None:
            counts[last.next_parameter] += 1
            group = range(4) if last.next_parameter < 4 else range(4, size)
            if last.next_parameter >= 4:
                covered = (*covered, find_next_region(last.calibration.camera, last.covered))
            std, before = (np.sqrt(np.diagonal(c.covariance)) for c in (calibration, last.calibration))
            decrease = 1 - std / np.maximum(before, 1e-300)
            converged |= {i for i in group if 0 <= decrease[i] <= CONVERGED_DECREASE}
        chosen = self._most_dispersed(calibration, frozenset(converged))
        return Progress(frozenset(converged), tuple(counts), covered, calibration, chosen)

    def _most_dispersed(self, calibration: Calibration, converged: frozenset[int]) -> int | None:
        """Parameter with the largest index of dispersion, variance / |value|, not yet converged."""
        variance = np.diagonal(calibration.covariance)
        dispersion = variance / np.maximum(np.abs(calibration.camera.intrinsics), 1e-12)
        left = [i for i in range(self.model.size) if i not in converged]
        return max(left, key=lambda i: float(dispersion[i])) if left else None

    def camera(self, views: Sequence[View]) -> Camera:
        """Camera that the method draws with: its last fit, or an assumed one before the second view."""
        if len(views) >= 2:
            calibration = self.progress(views).calibration
            if calibration is not None:
                return calibration.camera
        k = self.model.start(INITIAL_FOCAL_WIDTHS * self.img_size[0], self.img_size)
        return Camera.from_intrinsics(self.model.name, k, self.img_size)

    def _place_on_axis(self, r: Array) -> Array:
        center = np.array([0.0, 0.0, DISTANCE_LENGTHS * max(self.board.size)])
        return np.asarray(center - r @ self.board.outline.mean(axis=0))

    def _fronto_parallel_target(self, box: Box, camera: Camera, purpose: str) -> TargetPose:
        (w, h), (columns, rows) = self.img_size, self.board.size
        width = min(box.width * w, box.height * h * columns / rows)
        middle = np.array([[(box.left + box.width / 2) * w - 0.5, (box.top + box.height / 2) * h - 0.5]])
        ray = camera.unproject(middle)[0]
        if not np.isfinite(ray).all():
            ray = np.array([0.0, 0.0, 1.0])
        r = rotation.rotation_to_ray(ray)
        distance = columns * camera.focal[0] / width
        return self._target(r, ray * distance - r @ self.board.outline.mean(axis=0), camera, purpose)

    def _target(self, r: Array, t: Array, camera: Camera, purpose: str) -> TargetPose:
        last = None
        if self._steps and (calibration := self._steps[-1][1].calibration) is not None:
            pose = calibration.poses[-1]
            last = Placement.of(self.board, camera, rotation.matrix(pose[:3]), pose[3:])
        return TargetPose.seen(self.board, camera, r, t, purpose, 0.0, last)


def subdivided_tilt_deg(times: int) -> float:
    """Tilt of the target after `times` earlier ones for a parameter: -35, 35, -52.5, ..."""
    depth, place = 1, times
    while place >= 2**depth:
        place -= 2**depth
        depth += 1
    # Within a level from the outside in, sides in turn: the widest angles add most information.
    steps = 2 * TILT_RANGE_DEG / 2 ** (depth + 1)
    angles = [-TILT_RANGE_DEG + steps * (2 * i + 1) for i in range(2**depth)]
    return float(sorted(angles, key=lambda a: (-abs(a), a))[place])


def jaccard_index(one: Array, other: Array, img_size: tuple[int, int]) -> float:
    """Area of the intersection / area of the union of two polygons (m, 2) px, inside the image."""
    first, second = rasterize(one, img_size), rasterize(other, img_size)
    union = int(np.count_nonzero(first | second))
    return float(np.count_nonzero(first & second) / union) if union else 0.0


def rasterize(polygon: Array, img_size: tuple[int, int]) -> Mask:
    """Mask (h / MASK_PX, w / MASK_PX) of the inside of a polygon (m, 2) px, by the even-odd rule."""
    w, h = img_size
    mask: Mask = np.zeros((-(-h // MASK_PX), -(-w // MASK_PX)), dtype=bool)
    if len(polygon) < 3:
        return mask
    start = np.clip((np.asarray(polygon) + 0.5) / MASK_PX - 0.5, -1e4, 1e4)
    end = np.roll(start, -1, axis=0)
    rows, columns = (np.arange(n, dtype=np.float64) for n in mask.shape)
    crossed = (start[:, 1] <= rows[:, None]) != (end[:, 1] <= rows[:, None])
    fall = np.where(start[:, 1] == end[:, 1], 1.0, end[:, 1] - start[:, 1])
    x = start[:, 0] + (rows[:, None] - start[:, 1]) / fall * (end[:, 0] - start[:, 0])
    to_the_right = crossed[:, :, None] & (x[:, :, None] > columns)
    return np.asarray(to_the_right.sum(axis=1) % 2 == 1)


def estimate_outline(board: Board, view: View) -> Array:
    """Board's edge (m, 2) px, estimated from the corners of a view by a homography."""
    q = view.image_points
    middle, scale = q.mean(axis=0), max(float(np.abs(q - q.mean(axis=0)).max()), 1e-9)
    rays = np.concatenate([(q - middle) / scale, np.ones((len(q), 1))], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    homography = Homographies.fit_dlt(view.object_points.T[None], rays.T[None], np.ones((1, len(q))))
    edge = (edge_points(board)[:, :2] - homography.mean[0]) / homography.spread[0]
    edge_rays = np.concatenate([edge, np.ones((len(edge), 1))], axis=1) @ homography.h[0].T
    with np.errstate(all="ignore"):
        outline: Array = edge_rays[:, :2] / edge_rays[:, 2:] * scale + middle
    return np.asarray(outline[(edge_rays[:, 2] > 0) & np.isfinite(outline).all(axis=1)])
