"""Posterior of a camera's intrinsics: mean and Fisher information after only the prior, or a calibration."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import models
from ..arrays import Array, symmetric_inverse
from ..camera import Camera
from ..fitting import initial_guess, normal_equations, prior, systematic_effects, uncertainty
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import Poses
from ..fitting.observations import Observations
from ..models import Model
from ..view import View
from .candidates import RayGrid

ERROR_GRID = (12, 9)
NOMINAL_NOISE_WIDTHS = 0.3 / 1280
"""Standard deviation of a corner's coordinate / image width, before any measurement."""
MIN_NOISE_WIDTHS = 0.05 / 1280
"""The same of the best detector: residuals that are smaller by chance do not promise more."""
MAX_MEDIAN_ERROR_WIDTHS = 0.15
"""Median error / image width of a view with only its pose fitted; no lens explains more."""
NEGLIGIBLE_INFLATION = 1.5
"""Inflation that few views show by chance."""
USUAL_EXCESS_INFLATION = 3.0
"""Excess over it: the median of four to six views of 13 sets of real cameras."""
MAX_SHARE = 3.0
"""Largest size that is believed: beyond, a view is an outlier."""


@dataclass(frozen=True, eq=False)
class IntrinsicsPosterior:
    """Normal distribution of the intrinsics.

    Attributes
    ----------
    k
        (p,) mean.
    information
        (p, p) Fisher information: the inverse of their covariance, were the noise of the corners white.
    noise
        Standard deviation of a corner's coordinate, px.
    systematic
        As `systematic_share` returns.
    """

    model: Model
    k: Array
    information: Array
    noise: float
    img_size: tuple[int, int]
    systematic: float = 0.0

    @classmethod
    def of(
        cls,
        model_name: str,
        img_size: tuple[int, int],
        calibration: Calibration | None,
        seed: Camera | None = None,
    ) -> "IntrinsicsPosterior":
        """Posterior after a calibration, or only the prior, around a `seed` camera if there is one.

        The uncertainty of a seed is not used: the information is the prior's.
        """
        model = models.get(model_name)
        w = img_size[0]
        if calibration is None:
            k = model.start(model.prior.focal * w, img_size)
            if seed is not None and (seed.model, seed.img_size) == (model_name, img_size):
                k = seed.intrinsics
            return cls(model, k, prior.information(model, k, img_size), NOMINAL_NOISE_WIDTHS * w, img_size)
        k = calibration.camera.intrinsics
        noise = max(calibration.noise, MIN_NOISE_WIDTHS * w)
        information = calibration.information * (calibration.noise / noise) ** 2
        systematic = systematic_share(calibration.inflation)
        return cls(model, k, information, noise, img_size, systematic)

    @cached_property
    def camera(self) -> Camera:
        """Camera at the mean."""
        return Camera.from_intrinsics(self.model.name, self.k, self.img_size)

    @cached_property
    def rays(self) -> RayGrid:
        """Rays over the image."""
        return RayGrid.of(self.camera)

    @cached_property
    def error_metric(self) -> Array:
        """W (p, p): trace(covariance W) is the mean square projection error, px^2."""
        return uncertainty.image_error_metric(
            uncertainty.projection_jacobian_rotation_free(self.model, self.k, self.img_size, ERROR_GRID)
        )

    def view_information(self, obs: Observations, poses: Poses) -> Array:
        """Fisher information (v, p, p) of views at their poses, at unit noise; NaN of unseen ones."""
        s, q = self.limited_information(poses, obs.points, obs.mask.astype(np.float64))
        s[~np.isfinite(q).all(axis=(1, 2))] = np.nan
        return s

    def limited_information(self, poses: Poses, points: Array, weights: Array) -> tuple[Array, Array]:
        """Fisher information (v, p, p) of the intrinsics at unit noise, and pixels (v, 2, n).

        A view has information N, and a systematic error of its own that would move the intrinsics by a
        covariance T. Together they give (N^-1 + T)^-1, however low the noise of its corners. T differs from
        view to view: a bend shows most in a tilted close-up, motion wherever the board spans many rows. So
        the effects (`fitting.systematic_effects`) are variables of the view that are marginalised with its
        pose, with standard deviations typical of hand-held boards.

        Parameters
        ----------
        points
            (v, 3, n) or, for all views, (3, n); board frame.
        weights
            (v, n) of the points.
        """
        q, rows = normal_equations.linearize(self.model, self.k, poses, points, 0)
        count = 0
        if self.systematic > 0:
            row = systematic_effects.row_position(q[1], self.img_size[1])
            effects = systematic_effects.displacements(rows[self.model.size :], poses, points, row)
            count = len(effects)
            rows = np.concatenate([rows, effects * (self.systematic / self.noise)])
        rows = np.where(weights > 0, rows * np.sqrt(weights), 0.0)
        s = normal_equations.schur_complement(normal_equations.gram_matrices(rows), nuisance=count)
        return s, q.transpose(1, 0, 2)

    def gain(self, information: Array) -> float:
        """Decrease of the mean square error, px^2, by Fisher `information` (p, p) at unit noise."""
        w = self.error_metric
        before = symmetric_inverse(self.information)
        after = symmetric_inverse(self.information + information / self.noise**2)
        return float(np.sum((before - after) * w))

    def view_gain(self, view: View) -> float | None:
        """Decrease of the mean square error, px^2, by a view; None if the camera cannot pose it."""
        obs = Observations.of([view])
        posed = initial_guess.at(self.model, obs, self.k)
        if not posed.error < MAX_MEDIAN_ERROR_WIDTHS * self.img_size[0]:
            return None
        s = self.view_information(obs, posed.poses)[0]
        return self.gain(s) if np.isfinite(s).all() else None


def systematic_share(inflation: float) -> float:
    """Size of the systematic errors / the usual one, by the inflation that a calibration's views show.

    The excess of the inflation grows with the square of the systematic errors.
    """
    excess = inflation - NEGLIGIBLE_INFLATION
    return float(np.sqrt(np.clip(excess / USUAL_EXCESS_INFLATION, 0.0, MAX_SHARE**2)))
