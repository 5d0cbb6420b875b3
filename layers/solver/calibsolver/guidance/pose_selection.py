"""The published method: one parameter at a time, until the last view of each helped little.

Rojtberg & Kuijper, "Efficient Pose Selection for Interactive Camera Calibration" (ISMAR 2018) and "User
Guidance for Interactive Camera Calibration" (2019), as the papers describe it: plain least squares after each
view, the parameter with the largest index of dispersion next, tilted views for the intrinsics, views of the
most distorted part of the image for the coefficients. Offered as a peer; everything follows from the views.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import models, rotation
from ..arrays import Array
from ..board import Board
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..view import View
from .distorted_region import Box, next_region
from .hints import Placement, turn_to
from .overlap import jaccard, seen_outline
from .target import TargetPose

DISTANCE = 1.6
"""Board lengths at which tilted poses stand, whatever the lens."""
MOST_TILT = 70.0
"""Degrees to either side, subdivided."""
SHIFT = 0.05
"""Of the image, by which the board is moved for the principal point."""
OVERLAP = 0.85
"""Jaccard index of target and observed board from which a target is reached."""
SETTLED = 0.10
"""Relative fall of a standard deviation below which the parameter is done."""
POINTS = (27, 27, 15)
"""Corners that the first view, the second and every later one must have."""
FIRST_FOCAL = 1000 / 1280
"""Focal length / image width that is assumed at first."""
INTRINSICS = ("fx", "fy", "cx", "cy")


@dataclass(frozen=True, eq=False)
class Progress:
    """Where the method stands: parameters done, how often each was aimed at, regions shown, the last fit."""

    done: frozenset[int]
    aimed: tuple[int, ...]
    shown: tuple[Box, ...]
    calibration: Calibration | None
    next: int | None


class PoseSelection:
    """The guidance of the published method; see the module's docstring. `seed` is not used."""

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        seed: Camera | None = None,
    ) -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model)
        self.seed = seed
        self._steps: list[tuple[View, Progress]] = []

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Choose the next pose; the method knows no skipping: after one comes the next it would ask for."""
        del calibration, unreached  # the method fits for itself, and learns nothing of its user
        step = (len(views) + len(skipped)) if len(views) < 2 else len(views)
        if step == 0:
            r = rotation.matrix(np.radians([0, 45.0, 0])) @ rotation.matrix(np.radians([0, 0, 22.5]))
            return self._target(r, self._apart(r), self.camera(views), "a first look")
        if step == 1 or not views:
            return self._facing(Box(0.0, 0.0, 1.0, 1.0), self.camera(views), "to fill the picture")
        progress = self.progress(views)
        camera = self.camera(views)
        aimed = progress.next if progress.next is not None else 0
        times = progress.aimed[aimed] + len(skipped)
        if aimed >= len(INTRINSICS):
            region = next_region(camera, (*progress.shown,))
            return self._facing(region, camera, f"to measure {self.model.coefficients[aimed - 4]}")
        # fx and cx are seen in a tilt about the upright axis, fy and cy in one about the other.
        axis = np.array([0.0, 1.0, 0.0]) if aimed % 2 == 0 else np.array([1.0, 0.0, 0.0])
        r = rotation.matrix(np.radians(subdivision(times)) * axis)
        place = self._apart(r)
        if aimed >= 2:
            side = SHIFT * (1 if times % 2 == 0 else -1)
            off = side * np.array(self.img_size) * axis[[1, 0]]
            z = DISTANCE * max(self.board.size)
            place = place + np.array([*(off / np.diagonal(camera.matrix)[:2] * z), 0.0])
        return self._target(r, place, camera, f"to measure {INTRINSICS[aimed]}")

    def reached(self, target: TargetPose, view: View) -> bool:
        """Whether the board lies where the target does, and enough of it was seen."""
        if len(view) < min(POINTS[-1], self.board.corner_count):
            return False
        return jaccard(target.outline, seen_outline(self.board, view), self.img_size) > OVERLAP

    def done(self, views: Sequence[View]) -> bool:
        """Whether the method stops: every parameter is done."""
        return len(views) >= 2 and self.progress(views).next is None

    def estimate(self, views: Sequence[View]) -> Calibration | None:
        """Fit as the method does: plain least squares; None where that fails."""
        try:
            return fit(views, self.img_size, self.model.name, robust=False)
        except CalibrationError:
            return None

    def progress(self, views: Sequence[View]) -> Progress:
        """Replay the method over `views`; what was replayed before is remembered."""
        known = 0
        while known < min(len(views), len(self._steps)) and self._steps[known][0] is views[known]:
            known += 1
        del self._steps[known:]
        for i in range(known, len(views)):
            last = self._steps[-1][1] if self._steps else None
            self._steps.append((views[i], self._step(list(views[: i + 1]), last)))
        return self._steps[-1][1]

    def _step(self, views: list[View], last: Progress | None) -> Progress:
        size = self.model.size
        calibration = self.estimate(views) if len(views) >= 2 else None
        if last is None or last.calibration is None or calibration is None:
            chosen = None if calibration is None else self._widest(calibration, frozenset())
            return Progress(frozenset(), (0,) * size, (), calibration, 0 if chosen is None else chosen)
        done, aimed, shown = set(last.done), list(last.aimed), last.shown
        if last.next is not None:
            aimed[last.next] += 1
            group = range(4) if last.next < 4 else range(4, size)
            if last.next >= 4:
                shown = (*shown, next_region(last.calibration.camera, last.shown))
            std, before = (np.sqrt(np.diagonal(c.covariance)) for c in (calibration, last.calibration))
            fallen = 1 - std / np.maximum(before, 1e-300)
            done |= {i for i in group if 0 <= fallen[i] <= SETTLED}
        chosen = self._widest(calibration, frozenset(done))
        return Progress(frozenset(done), tuple(aimed), shown, calibration, chosen)

    def _widest(self, calibration: Calibration, done: frozenset[int]) -> int | None:
        """Return the parameter with the largest index of dispersion, variance / |value|, not yet done."""
        variance = np.diagonal(calibration.covariance)
        dispersion = variance / np.maximum(np.abs(calibration.camera.intrinsics), 1e-12)
        left = [i for i in range(self.model.size) if i not in done]
        return max(left, key=lambda i: float(dispersion[i])) if left else None

    def camera(self, views: Sequence[View]) -> Camera:
        """Return the camera that the method believes in: nothing before the second view."""
        if len(views) >= 2:
            calibration = self.progress(views).calibration
            if calibration is not None:
                return calibration.camera
        k = self.model.start(FIRST_FOCAL * self.img_size[0], self.img_size)
        return Camera.from_intrinsics(self.model.name, k, self.img_size)

    def _apart(self, r: Array) -> Array:
        """Return the translation that puts the board's centre on the axis, DISTANCE away."""
        center = np.array([0.0, 0.0, DISTANCE * max(self.board.size)])
        place: Array = center - r @ self.board.outline.mean(axis=0)
        return place

    def _facing(self, box: Box, camera: Camera, purpose: str) -> TargetPose:
        """Fronto-parallel target that fills a part of the image as far as its shape allows."""
        (w, h), (columns, rows) = self.img_size, self.board.size
        width = min(box.width * w, box.height * h * columns / rows)
        middle = np.array([[(box.left + box.width / 2) * w - 0.5, (box.top + box.height / 2) * h - 0.5]])
        ray = camera.unproject(middle)[0]
        if not np.isfinite(ray).all():
            ray = np.array([0.0, 0.0, 1.0])
        r = rotation.matrix(turn_to(ray))
        distance = columns * camera.matrix[0, 0] / width
        return self._target(r, ray * distance - r @ self.board.outline.mean(axis=0), camera, purpose)

    def _target(self, r: Array, t: Array, camera: Camera, purpose: str) -> TargetPose:
        last = None
        if self._steps and (calibration := self._steps[-1][1].calibration) is not None:
            pose = calibration.poses[-1]
            last = Placement.of(self.board, camera, rotation.matrix(pose[:3]), pose[3:])
        return TargetPose.seen(self.board, camera, r, t, purpose, 0.0, last)


def subdivision(times: int) -> float:
    """Return the angle, degrees, at which a parameter is aimed at for the n-th time: -35, 35, -52.5, ..."""
    depth, place = 1, times
    while place >= 2**depth:
        place -= 2**depth
        depth += 1
    # Within a level from the outside in, sides in turn: the widest angles tell most.
    steps = 2 * MOST_TILT / 2 ** (depth + 1)
    angles = [-MOST_TILT + steps * (2 * i + 1) for i in range(2**depth)]
    return float(sorted(angles, key=lambda a: (-abs(a), a))[place])
