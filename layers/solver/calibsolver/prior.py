"""A weak belief about the intrinsics as a few extra residuals."""

import numpy as np

from .arrays import Array
from .models import Model


def residuals(model: Model, k: Array, img_size: tuple[int, int]) -> tuple[Array, Array]:
    """Whitened residuals (p,) of the model's prior at k (p,), and their Jacobian (p, p).

    In this order: log focal length, log aspect, principal point, distortion coefficients.
    """
    prior = model.prior
    w, h = img_size
    log_x, log_y = np.log(k[0]), np.log(k[1])
    r = np.empty(model.size)
    r[0] = ((log_x + log_y) / 2 - np.log(prior.focal * w)) / prior.focal_sigma
    r[1] = (log_x - log_y) / prior.aspect_sigma
    r[2:4] = (k[2:4] - ((w - 1) / 2, (h - 1) / 2)) / (prior.center_sigma * w)
    r[4:] = k[4:] / np.asarray(prior.distortion_sigma)
    j = np.diag(np.concatenate([[0, 0, 1, 1], np.ones(model.size - 4)]))
    j[0, :2] = 0.5 / k[:2] / prior.focal_sigma
    j[1, :2] = (1 / k[0] / prior.aspect_sigma, -1 / k[1] / prior.aspect_sigma)
    j[[2, 3], [2, 3]] /= prior.center_sigma * w
    j[range(4, model.size), range(4, model.size)] /= np.asarray(prior.distortion_sigma)
    return r, j


def information(model: Model, k: Array, img_size: tuple[int, int]) -> Array:
    """Information matrix (p, p) of the prior at k."""
    _, j = residuals(model, k, img_size)
    m: Array = j.T @ j
    return m
