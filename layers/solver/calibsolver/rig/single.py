"""A single camera of a rig: fitted to its own views, or its views resected."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.approximation import Approximation, approximate
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..fitting.normal_equations import Poses
from ..fitting.resection import resect
from ..fitting.validation import MIN_POINTS, check
from ..view import View
from .problem import Moment
from .start import RigidMotion

Specification = Camera | tuple[tuple[int, int], str]
"""A camera whose intrinsics are held, or the image size (width, height) in px and the model to be fitted."""


@dataclass(frozen=True, eq=False)
class Single:
    """A single camera: intrinsics, whether they are fixed, poses and reasons by moment, noise in px."""

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
    all_poses = Poses.of_vectors(np.asarray(result.poses))
    poses = {
        m: RigidMotion(all_poses.r[i], all_poses.t[i])
        for i, m in enumerate(numbers)
        if i not in result.cut_views
    }
    reasons = {numbers[i]: reason for i, reason in result.cut_views.items()}
    return Single(result.camera, False, poses, reasons, result.noise)


def _resect(camera: Camera, numbers: Sequence[int], views: Sequence[View], robust: bool) -> Single:
    """Resect the views of a camera whose intrinsics are held."""
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
    return Single(
        camera,
        True,
        {numbers[usable[i]]: RigidMotion(poses.r[i], poses.t[i]) for i in np.flatnonzero(finite).tolist()},
        {m: "outlier" for i, m in enumerate(numbers) if i not in usable or not finite[usable.index(i)]},
        float(np.sqrt(np.median(spread))),
    )
