"""Input validation for `fit`: degenerate, mirrored and absurd views."""

from collections.abc import Iterable

import numpy as np

from ..arrays import Array, Mask
from ..errors import CalibrationError
from ..view import View
from .observations import Observations

MIN_POINTS = 6
"""A view has six unknowns; fewer points determine nothing of the camera."""
MIN_FLATNESS_BOARD, MIN_FLATNESS_IMAGE = 0.02, 1e-3
"""Smaller / larger extent of points below which they lie on a line, on the board and in the image."""
MIN_EXTENT_PX = 4.0
"""Extent of the points in the image below which they lie in one place."""
MAX_RELIEF = 0.1
"""Height of a bent board over its plane / its longer side."""
MAX_IMAGE_DISTANCE, MAX_BOARD_DISTANCE = 10.0, 1e9
"""Image sizes from the middle of the image, and units of the board, within which points are."""


MAX_OUTSIDE = 0.05
"""Distance of a point from the image / its longer side, above which the size is wrong."""


def check(views: Iterable[View], img_size: tuple[int, int]) -> Observations:
    """Pack views, or raise CalibrationError for those that no fit could use, see `fit`."""
    obs = pack(views, img_size)
    refuse(degenerate_views(obs), "degenerate", "the points of view {} lie on a line or in one place")
    return obs


def pack(views: Iterable[View], img_size: tuple[int, int]) -> Observations:
    """Pack views as `check` does, with the degenerate ones."""
    views = list(views or ())
    try:
        w, h = img_size
    except (TypeError, ValueError):
        raise CalibrationError("out_of_range", f"an image has a width and a height, not {img_size}") from None
    if not (1 < w < 100_000 and 1 < h < 100_000):
        raise CalibrationError("out_of_range", f"an image of {w} x {h} px cannot be calibrated")
    if not views:
        raise CalibrationError("no_views", "there is no view to fit")
    for i, view in enumerate(views):
        if len(view) < MIN_POINTS:
            raise CalibrationError(
                "too_few_points", f"view {i} has {len(view)} points, {MIN_POINTS} are needed"
            )
    obs = in_range(Observations.of(views), img_size)
    half = np.array([[w / 2], [h / 2]])
    beyond = np.abs(obs.pixels + 0.5 - half) - half  # of the outer edge of the outermost pixels
    refuse(
        beyond.max(axis=(1, 2)) > MAX_OUTSIDE * max(w, h),
        "outside_image",
        f"view {{}} has points outside the image of {w} x {h} px",
    )
    extent = obs.points.max(axis=2) - obs.points.min(axis=2)
    refuse(
        extent[:, 2] > MAX_RELIEF * np.maximum(extent[:, 0], extent[:, 1]),
        "not_planar",
        "the points of view {} do not lie on a board",
    )
    return obs


def degenerate_views(obs: Observations) -> Mask:
    """Views (v,) whose points lie on a line or in one place: they have no pose of their own."""
    p, q = obs.points, obs.pixels
    small = (q.max(axis=2) - q.min(axis=2)).max(axis=1) < MIN_EXTENT_PX
    flat = (flatness(p[:, :2], obs.mask) < MIN_FLATNESS_BOARD) | (flatness(q, obs.mask) < MIN_FLATNESS_IMAGE)
    degenerate: Mask = small | flat
    return degenerate


def in_range(obs: Observations, img_size: tuple[int, int]) -> Observations:
    """Observations whose points are within the range of the computations; raises CalibrationError."""
    middle = np.array([[img_size[0] / 2], [img_size[1] / 2]])
    off = np.abs(obs.pixels - middle).max(axis=(1, 2)) > MAX_IMAGE_DISTANCE * max(img_size)
    refuse(
        off | (np.abs(obs.points).max(axis=(1, 2)) > MAX_BOARD_DISTANCE),
        "out_of_range",
        "view {} has points far outside the image or the board",
    )
    return obs


def refuse(bad: Mask, code: str, message: str) -> None:
    """Raise CalibrationError that names the first of the views (v) that are `bad`, if there is one."""
    if bad.any():
        raise CalibrationError(code, message.format(int(np.argmax(bad))))


def subtract_mean(points: Array, mask: Mask) -> Array:
    """Points (v, 2, n) relative to the mean of those in the mask (v, n); 0 elsewhere."""
    mean = (points @ (mask / mask.sum(axis=1, keepdims=True))[:, :, None]) if not mask.all() else None
    out: Array = points - (points.mean(axis=2, keepdims=True) if mean is None else mean)
    return out if mean is None else out * mask[:, None]


def flatness(points: Array, mask: Mask) -> Array:
    """Smaller over larger principal extent (v,) of points (v, 2, n): 0 if they lie on a line."""
    x = subtract_mean(points, mask)
    m = x @ x.transpose(0, 2, 1)
    xx, yy, xy = m[:, 0, 0], m[:, 1, 1], m[:, 0, 1]
    # Eigenvalues of the 2x2 scatter matrix; the smaller from the determinant, free of cancellation.
    larger = (xx + yy + np.hypot(xx - yy, 2 * xy)) / 2
    return np.sqrt(np.maximum(xx * yy - xy * xy, 0.0)) / np.maximum(larger, 1e-300)


def handedness(obs: Observations) -> Array:
    """Determinant (v,) of the best affine map from board to image: negative if mirrored.

    Unlike that of a homography it stays defined under strong distortion.
    """
    m = subtract_mean(obs.points[:, :2], obs.mask) @ obs.pixels.transpose(0, 2, 1)
    return m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0]


def mirrored_views(obs: Observations) -> Mask:
    """Views (v,) that show the board mirrored, unlike most: the direction of z is a convention."""
    mirrored: Mask = handedness(obs) < 0
    return ~mirrored if mirrored.mean() > 0.5 else mirrored
