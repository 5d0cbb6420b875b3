"""A weak belief about the intrinsics as a few extra residuals."""

import math
from functools import lru_cache

import numpy as np

from ..arrays import Array
from ..models import Model

MAX_SQUARED_RADIUS = 6.0
"""Squared image radius, in focal lengths, towards which that of ever wider lenses saturates. On a fisheye
of 180 degrees and more the distortion is a series in the angle, which ends at about 1.6."""
STRETCH = ((0.5, 0.2), (0.8, 0.35), (1.1, 0.5))
"""Image radius / distance of the corner, and standard deviation of the radial stretch there,
d(distorted)/d(undistorted radius), from 1: without this the coefficients, each modest, may fold the
corners."""


class Weights:
    """Constant part of a model's prior."""

    def __init__(self, model: Model) -> None:
        c = model.prior.distortion
        self.order = np.array([float(x.order) for x in c])
        self.mean = np.array([x.mean for x in c])
        radii, self.sigmas = np.array(STRETCH).T
        self.squares = radii**2
        # d(radial stretch)/d(coefficient) of a term that multiplies the squared radius to the power `order`
        slope = (
            np.array([x.sign * (2 * x.order + 1) if x.order else 0 for x in c])
            * radii[:, None] ** (2 * self.order)
            / self.sigmas[:, None]
        )
        # Jacobian of the residuals after the fourth by the coefficients: `plain`, and `grown` by the reach.
        edge = np.diag([1 / x.edge if x.order else 0.0 for x in c])
        self.plain = np.concatenate([np.diag([1 / x.sigma for x in c]), np.zeros_like(slope)])
        self.grown = np.concatenate([edge, slope])


@lru_cache(maxsize=16)
def weights(model: Model) -> Weights:
    """Constants of a model's prior."""
    return Weights(model)


def residuals(model: Model, k: Array, img_size: tuple[int, int]) -> tuple[Array, Array]:
    """Whitened residuals (m,) of the model's prior at k (p,), and their Jacobian (m, p).

    In this order: log focal length, log aspect, principal point, distortion coefficients, radial stretches.
    """
    prior, fixed = model.prior, weights(model)
    w, h = img_size
    size = model.size
    fx, fy, cx, cy = k[:4].tolist()
    d = k[4:]
    magnified, by_d = model.magnification(d)
    r = np.empty(size + len(STRETCH))
    j = np.zeros((len(r), size))
    r[0] = (math.log(fx * fy) / 2 + math.log(magnified / (prior.focal * w))) / prior.focal_sigma
    r[1] = math.log(fx / fy) / prior.aspect_sigma
    r[2] = (cx - (w - 1) / 2) / (prior.center_sigma * w)
    r[3] = (cy - (h - 1) / 2) / (prior.center_sigma * w)
    j[0, 0], j[0, 1] = 0.5 / (fx * prior.focal_sigma), 0.5 / (fy * prior.focal_sigma)
    j[0, 4:] = by_d / (magnified * prior.focal_sigma)
    j[1, 0], j[1, 1] = 1 / (fx * prior.aspect_sigma), -1 / (fy * prior.aspect_sigma)
    j[2, 2] = j[3, 3] = 1 / (prior.center_sigma * w)
    square = (w * w + h * h) / (4 * fx * fy)
    saturation = 1 + square / MAX_SQUARED_RADIUS
    reach = (square / saturation) ** fixed.order
    # d(log reach)/d(log f), the same for both focal lengths
    by_focal = -fixed.order / saturation
    grown = fixed.grown * reach
    by_distortion = np.add(fixed.plain, grown, out=j[4:, 4:])
    r[4:] = by_distortion @ (d - fixed.mean)
    by_log = grown @ (d * by_focal)
    s = fixed.squares * square / saturation
    exact = model.radial_derivative(d, s)
    if exact is not None:
        value, by_d, by_s = exact
        # Above 1 by its logarithm, which is the same to first order: near a pole it grows without bound.
        least = np.maximum(value, 1)
        certain = 1 / (fixed.sigmas * least)
        r[size:] = np.where(value > 1, np.log(least), value - 1) / fixed.sigmas
        j[size:, 4:] = by_d * certain[:, None]
        by_log[size - 4 :] = -by_s * s / saturation * certain
    j[4:, 0], j[4:, 1] = by_log / fx, by_log / fy
    return r, j


def information(model: Model, k: Array, img_size: tuple[int, int]) -> Array:
    """Information matrix (p, p) of the prior at k."""
    _, j = residuals(model, k, img_size)
    return j.T @ j
