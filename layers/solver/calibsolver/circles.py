"""Grids of circles: the bias of centroids, which detectors measure, and fits without it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from . import rotation
from .arrays import Array
from .camera import Camera
from .fitting.calibration import Calibration
from .fitting.constraint import Fix
from .fitting.fit import fit
from .view import View

RIM_POINTS = 64
ROUNDS = 3
"""Fits, each of centres corrected by the one before."""


def centre_bias(camera: Camera, view: View, pose: Array, radius: float) -> Array:
    """Centroid of the picture of each circle minus the picture of its centre, (n, 2) px.

    Perspective and distortion move it. `pose` is rvec|tvec, board -> camera, `radius` in board units.
    """
    angle = np.linspace(0, 2 * np.pi, RIM_POINTS, endpoint=False)
    rim = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    r = rotation.matrix(pose[:3])
    places = view.object_points[:, None] + rim[None]
    x, y = np.moveaxis(camera.project(places @ r.T + pose[3:]), -1, 0)
    # of the polygon of the rim: its area's centroid (Green's theorem)
    u, v = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    cross = x * v - u * y
    area = cross.sum(axis=1)
    centroid = np.stack([((x + u) * cross).sum(axis=1), ((y + v) * cross).sum(axis=1)], axis=1)
    bias: Array = centroid / (3 * area[:, None]) - camera.project(view.object_points @ r.T + pose[3:])
    return bias


def fit_circles(
    views: Sequence[View],
    img_size: tuple[int, int],
    radius: float,
    model: str = "rectilinear",
    *,
    start: Camera | None = None,
    fix: Fix = (),
) -> tuple[Calibration, tuple[View, ...]]:
    """Fit a camera to centroids of circles, corrected by their bias; also return the corrected views.

    Other arguments, and errors, as of `fit`.
    """
    corrected = tuple(views)
    calibration = fit(corrected, img_size, model, start=start, fix=fix, board_shape=False)
    for _ in range(ROUNDS - 1):
        moved = []
        for view, pose in zip(views, calibration.poses, strict=True):
            # Degenerate views have no pose.
            bias = np.nan_to_num(centre_bias(calibration.camera, view, pose, radius))
            moved.append(replace(view, image_points=view.image_points - bias))
        corrected = tuple(moved)
        calibration = fit(
            corrected, img_size, model, start=calibration.camera, fix=calibration.fixed, board_shape=False
        )
    return calibration, corrected
