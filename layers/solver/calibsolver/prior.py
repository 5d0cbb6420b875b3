"""A weak belief about the intrinsics as a few extra residuals."""

import math

import numpy as np

from .arrays import Array
from .models import Model

WIDEST = 6.0
"""Squared image radius, in focal lengths, towards which that of ever wider lenses saturates: on a fisheye
of 180 degrees and more the distortion is a series in the angle, which stops at about 1.6 where the radius
goes on."""
STRETCH = ((0.5, 0.2), (0.8, 0.35), (1.1, 0.5))
"""Image radius / distance of the corner, and how far the radial stretch there, d(distorted)/d(undistorted
radius), is believed to lie from 1: without this the coefficients, each modest, may fold the corners between
them."""

RADII, SIGMAS = np.array(STRETCH).T


def residuals(model: Model, k: Array, img_size: tuple[int, int]) -> tuple[Array, Array]:
    """Whitened residuals (m,) of the model's prior at k (p,), and their Jacobian (m, p).

    In this order: log focal length, log aspect, principal point, distortion coefficients, radial stretches.
    """
    prior = model.prior
    w, h = img_size
    size = model.size
    r = np.zeros(size + len(STRETCH))
    j = np.zeros((len(r), size))
    log_x, log_y = math.log(k[0]), math.log(k[1])
    r[0] = ((log_x + log_y) / 2 - math.log(prior.focal * w)) / prior.focal_sigma
    r[1] = (log_x - log_y) / prior.aspect_sigma
    r[2] = (k[2] - (w - 1) / 2) / (prior.center_sigma * w)
    r[3] = (k[3] - (h - 1) / 2) / (prior.center_sigma * w)
    j[0, :2] = 0.5 / k[:2] / prior.focal_sigma
    j[1, 0], j[1, 1] = 1 / k[0] / prior.aspect_sigma, -1 / k[1] / prior.aspect_sigma
    j[2, 2] = j[3, 3] = 1 / (prior.center_sigma * w)
    square = (w * w + h * h) / (4 * k[0] * k[1])
    sigma, order, edge, sign, mean = prior.columns
    d = k[4:]
    magnified, by_d = model.magnification(d)
    r[0] += math.log(magnified) / prior.focal_sigma
    j[0, 4:] = by_d / (magnified * prior.focal_sigma)
    reach = (square / (1 + square / WIDEST)) ** order
    # d(log reach)/d(log f), the same for both focal lengths
    by_focal = -order / (1 + square / WIDEST)
    r[4:size] = (d - mean) * (1 / sigma + edge * reach)
    j[range(4, size), range(4, size)] = 1 / sigma + edge * reach
    j[4:size, :2] = (d * edge * reach * by_focal)[:, None] / k[:2]
    # d(radius stretch)/d(coefficient) for a term that multiplies the squared radius to the power `order`
    slope = sign * (2 * order + 1) * (order > 0) * reach * RADII[:, None] ** (2 * order) / SIGMAS[:, None]
    r[size:] = slope @ d
    j[size:, 4:] = slope
    j[size:, :2] = (slope @ (d * by_focal))[:, None] / k[:2]
    return r, j


def information(model: Model, k: Array, img_size: tuple[int, int]) -> Array:
    """Information matrix (p, p) of the prior at k."""
    _, j = residuals(model, k, img_size)
    m: Array = j.T @ j
    return m
