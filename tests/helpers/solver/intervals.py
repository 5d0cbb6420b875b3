"""Comparison of predicted and actual errors: many captures of cameras whose truth is known."""

from dataclasses import dataclass

import numpy as np

from calibsolver import CalibrationError, fit
from tests.helpers.solver import populations, synthetic

POPULATIONS = {
    "rectilinear": synthetic.rectilinear_cameras,
    "fisheye": synthetic.fisheye_cameras,
    "rational": populations.rational_cameras,
    "omnidirectional": populations.omnidirectional_cameras,
}


@dataclass(frozen=True)
class Intervals:
    """Results of many captures, each of another camera.

    `ratio` (s,): rms over the image of the projection error / of the predicted one. `z` (s, p): errors of the
    intrinsics / their predicted deviations. `out_of_domain`: captures whose result lacks a ray for some pixel
    that the camera has one for. `failed`: captures without a fit.
    """

    ratio: np.ndarray
    z: np.ndarray
    out_of_domain: int
    failed: int

    @property
    def projection(self) -> float:
        return float(np.sqrt(np.mean(self.ratio**2)))

    @property
    def coverage(self) -> np.ndarray:
        """Share (p,) of the captures whose 95 % interval contains the true parameter."""
        share: np.ndarray = np.mean(np.abs(self.z) < 1.959964, axis=0)
        return share


def measure(model: str, captures: int, views: int = 8) -> Intervals:
    rng = np.random.default_rng(0)
    ratio, z, out_of_domain, failed = [], [], 0, 0
    for camera in POPULATIONS[model](captures):
        try:
            c = fit(populations.views(camera, rng, count=views), camera.img_size, model)
        except CalibrationError:
            failed += 1
            continue
        predicted = c.projection_std().ravel()
        error = synthetic.projection_error(camera, c.camera)
        seen = np.isfinite(predicted) & (error < camera.img_size[0])
        out_of_domain += not seen.all()
        ratio.append(np.sqrt(np.mean(error[seen] ** 2) / np.mean(predicted[seen] ** 2)))
        z.append((c.camera.intrinsics - camera.intrinsics) / np.sqrt(np.diag(c.covariance)))
    return Intervals(np.array(ratio), np.array(z), out_of_domain, failed)
