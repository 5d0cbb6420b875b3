"""Spacing of an AprilGrid in pictures: by the places of the tags' corners, then by a fit of the camera."""

import statistics
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import calibsolver
from calibsolver.arrays import Array

from ..board import Board
from .aprilgrid import AprilGridFinder, corners_of_tags, local_distances
from .corners import Corners, refine

USUAL_SPACINGS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6)
"""Spacings that boards are printed with; Kalibr's own is 0.3."""
MAX_SNAP, MAX_SNAP_COARSE = 0.012, 0.022
"""Difference from a usual spacing up to which that is meant: of a fit, and of places only."""
MIN_TAGS = 10
"""Tags in an image from which the spacing follows."""
MAX_CURVE_RATIO = 0.6
"""Least distance from smooth places over the trials / the median of them: else nothing is determined."""
MAX_DISAGREEMENT = 0.08
"""Difference between the spacings of two pictures beyond which they show no common board."""
COARSE = np.arange(0.08, 0.82, 0.025)
FINE = np.arange(-0.04, 0.0401, 0.01)
MODEL = "fisheye"
"""Distortion model of the fit: it follows narrow lenses and wide ones."""


def estimate_spacing(grid: Board, greys: Sequence[Any]) -> float | None:
    """Return the spacing of an AprilGrid in pictures (h, w); None if they do not tell, or disagree."""
    if grid.inverted:
        greys = [255 - grey for grey in greys]
    finder = AprilGridFinder(grid)
    shown = [(grey, tags) for grey in greys if (tags := finder.tags(grey)) is not None]
    coarse = [each for grey, tags in shown if (each := _coarse_spacing(grid, grey, *tags)) is not None]
    if not coarse or max(coarse) - min(coarse) > MAX_DISAGREEMENT:
        return None
    start = statistics.median(coarse)
    fitted = _fitted_spacing(replace(grid, tag_spacing=start), shown)
    spacing, tolerance = (fitted, MAX_SNAP) if fitted is not None else (start, MAX_SNAP_COARSE)
    usual = min(USUAL_SPACINGS, key=lambda each: abs(each - spacing))
    return usual if abs(usual - spacing) <= tolerance else round(spacing, 3)


def _coarse_spacing(grid: Board, grey: Any, tags: Any, quads: Array) -> float | None:
    """Return the spacing at which the refined corners of one picture's tags lie most smoothly."""
    if len(tags) < MIN_TAGS:
        return None
    distances = np.full(len(COARSE), np.inf)
    for n, spacing in enumerate(COARSE.tolist()):
        board = replace(grid, tag_spacing=spacing)
        ids, places = corners_of_tags(board, tags, quads)
        corners = refine(grey, board, ids, places)
        # Between the tags nothing moves a corner: there is none.
        if corners is None or len(corners.ids) < 0.8 * len(ids) or _share_unmoved(corners, ids, places) > 0.3:
            continue
        distances[n] = np.median(local_distances(board, corners.ids, corners.points))
    finite = distances[np.isfinite(distances)]
    if not len(finite) or finite.min() > MAX_CURVE_RATIO * float(np.median(finite)):
        return None
    return float(COARSE[int(np.argmin(distances))])


def _share_unmoved(corners: Corners, ids: Any, places: Any) -> float:
    index = {int(corner): n for n, corner in enumerate(ids)}
    before = places[[index[corner] for corner in corners.ids]]
    return float((np.linalg.norm(corners.points - before, axis=1) < 0.02).mean())


def _fitted_spacing(grid: Board, shown: Sequence[tuple[Any, tuple[Any, Array]]]) -> float | None:
    """Return the spacing at which a camera explains the corners of all pictures best; None without a fit."""
    refined = (refine(grey, grid, *corners_of_tags(grid, *tags)) for grey, tags in shown)
    views = [corners for corners in refined if corners is not None]
    if len(views) < 2:
        return None
    h, w = shown[0][0].shape
    trials, errors = [], []
    for step in FINE.tolist():
        board = replace(grid, tag_spacing=grid.tag_spacing + step)
        try:
            seen = [board.view(each.ids, each.points) for each in views]
            fit = calibsolver.fit(seen, (w, h), MODEL, board_shape=False)
        except calibsolver.CalibrationError:
            continue
        trials.append(board.tag_spacing)
        errors.append(float(np.median(np.linalg.norm(np.concatenate(fit.residuals), axis=1))))
    if not errors:
        return None
    best = int(np.argmin(errors))
    if not 0 < best < len(errors) - 1:
        return None
    left, middle, right = errors[best - 1 : best + 2]  # of a parabola through three
    shift = 0.5 * (left - right) / max(left - 2 * middle + right, 1e-9)
    return float(trials[best] + float(np.clip(shift, -0.5, 0.5)) * 0.01)
