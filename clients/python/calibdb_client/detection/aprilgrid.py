"""AprilGrid in pictures: tags by cv2.aruco, corners numbered as Kalibr does, and the spacing of tags."""

import statistics
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import calibsolver
from calibsolver.arrays import Array

from ..board import MIN_CORNERS, Board, opencv
from .corners import Corners, refine

NEIGHBOURS = 9
"""Tags, itself counted, whose corners tell where a tag's are."""
BORDERS = (2, 1)
"""Cells of black around a tag: Kalibr prints two, OpenCV and the AprilTag library one."""
MIN_CERTAIN_TAGS = 4
"""Tags of one border after which the other is not looked for any more."""
MIN_SMOOTHED_TAGS = 6
"""Tags from which neighbours tell where a corner is: fewer are large, and a lens bends them."""
REWEIGHTINGS = 8
MIN_STRAY_PX = 1.0
"""Distance from where its neighbours say up to which a corner is none of another thing."""
MAX_STRAY_RATIO = 6.0
USUAL_SPACINGS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6)
"""Spacings that boards are printed with; Kalibr's own is 0.3."""
MAX_SNAP, MAX_SNAP_COARSE = 0.012, 0.022
"""Difference from a usual spacing up to which that is meant: of a fit, and of places only."""
MIN_TAGS = 10
MAX_CURVE_RATIO = 0.6
"""Least distance from smooth places over the trials / the median of them: else nothing is determined."""
MAX_DISAGREEMENT = 0.08
"""Difference between the spacings of two pictures beyond which they show no common board."""
COARSE = np.arange(0.08, 0.82, 0.025)
FINE = np.arange(-0.04, 0.0401, 0.01)
MODEL = "fisheye"
"""Distortion model of the fit: it follows narrow lenses and wide ones."""


class AprilGridFinder:
    """Finder of the tags of one board, whichever border and whichever way up they were printed."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self._detectors = [_tag_detector(board.markers(), border) for border in BORDERS]

    def __call__(self, grey: Any) -> tuple[Any, Any] | None:
        """Return ids (n,) and corners (n, 2) px in a picture (h, w); None if none of its tags is seen."""
        tags = self.tags(grey)
        return None if tags is None else _corners_of_tags(self.board, *tags)

    def tags(self, grey: Any) -> tuple[Any, Array] | None:
        """Return ids (n,) and corners (n, 4, 2) px of the tags in a picture; None if there is but one."""
        count = self.board.squares[0] * self.board.squares[1]
        results = [_find_tags(detector, grey, count) for detector in self._detectors]
        ids, tags = max(results, key=lambda each: len(each[0]))
        if len(ids) >= MIN_CERTAIN_TAGS:  # only this border from now on
            self._detectors = [d for d, each in zip(self._detectors, results, strict=True) if each[0] is ids]
        return None if len(ids) < 2 else (ids, tags)


def _corners_of_tags(board: Board, ids: Any, tags: Array) -> tuple[Any, Any]:
    """Return ids (n,) and corners (n, 2) px of tags, numbered as the board's, smoothed by tags around.

    Contours run from a tag into the squares that are printed into the corners between tags: single corners
    lie some pixels off.
    """
    corners = (4 * ids[:, None] + np.arange(4)).reshape(-1)
    points = _number_corners(board, ids, tags).reshape(-1, 2)
    if len(ids) >= MIN_SMOOTHED_TAGS:
        points = _smoothed(board, corners, points)
    return corners, points.astype(np.float32)


def _number_corners(board: Board, ids: Any, tags: Array) -> Array:
    """Return the corners (n, 4, 2) px of tags, anticlockwise from the lower left on the upright board.

    Detectors begin with the first corner of the tag's code, which prints turn as they like. The places of the
    tags say how the board is turned: a similarity from the board to the picture, without mirroring.
    """
    places = board.places.reshape(-1, 4, 2)[ids]
    middles, centres = places.mean(axis=1), tags.mean(axis=1)
    a = (middles - middles.mean(axis=0)) @ [1, 1j]
    b = (centres - centres.mean(axis=0)) @ [1, 1j]
    turn = np.vdot(a, b)
    turn /= max(abs(turn), 1e-12)
    expected = ((places - middles[:, None]) @ [1, 1j]) * turn
    # Detectors list corners clockwise, Kalibr anticlockwise.
    offsets = ((tags - centres[:, None]) @ [1, 1j])[:, ::-1]
    agreement = [float(np.real(np.conj(expected) * np.roll(offsets, k, axis=1)).sum()) for k in range(4)]
    return np.roll(tags[:, ::-1], int(np.argmax(agreement)), axis=1)


def _local_distances(board: Board, ids: Any, points: Array) -> Array:
    """Distance (n,) px of corners from where those of the tags around each, and itself, say that they are."""
    distances: Array = np.linalg.norm(_smoothed(board, np.asarray(ids), points) - points, axis=1)
    return distances


def without_stray_corners(board: Board, corners: Corners) -> Corners | None:
    """Return the corners that lie where their neighbours say; None if too few do.

    Next to a tag's corner are those of the square in the gap, to which refinement may run.
    """
    distances = _local_distances(board, corners.ids, corners.points)
    indices = np.flatnonzero(distances <= max(MIN_STRAY_PX, MAX_STRAY_RATIO * float(np.median(distances))))
    if len(indices) < MIN_CORNERS:
        return None
    return Corners(tuple(corners.ids[n] for n in indices), corners.points[indices])


def _smoothed(board: Board, ids: Any, points: Array) -> Array:
    """Return corners (n, 2) px where those of the tags around each say that they are.

    A homography of all corners, and what a lens adds to it near a tag: a quadratic map, robust by reweighted
    least squares.
    """
    places = board.places[ids]
    middles = board.places.reshape(-1, 4, 2).mean(axis=1)[ids // 4]
    matrix, _ = opencv().findHomography(places, points, 0)
    plane = points * 0 if matrix is None else opencv().perspectiveTransform(places[None], matrix)[0]
    apart = np.abs(middles[:, None] - middles[None]).max(axis=2)
    near = np.argsort(apart, axis=1, kind="stable")[:, : 4 * NEIGHBOURS]
    terms, rest = _terms(places[near] - middles[:, None]), (points - plane)[near]
    weights = np.ones(near.shape)
    for _ in range(REWEIGHTINGS):
        weighted = np.swapaxes(terms * weights[..., None], 1, 2)
        maps = np.linalg.pinv(weighted @ terms, hermitian=True) @ (weighted @ rest)
        off = np.linalg.norm(terms @ maps - rest, axis=2)
        weights = 1 / (1 + (off / (2.2 * np.median(off, axis=1, keepdims=True) + 1e-9)) ** 2)
    smooth: Array = plane + (_terms((places - middles)[:, None]) @ maps)[:, 0]
    return smooth


def _terms(places: Array) -> Array:
    x, y = places[..., 0], places[..., 1]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def _tag_detector(dictionary: Any, border: int) -> Any:
    aruco = opencv().aruco
    parameters = aruco.DetectorParameters()
    parameters.markerBorderBits = border
    return aruco.ArucoDetector(dictionary, parameters)


def _find_tags(detector: Any, grey: Any, count: int) -> tuple[Any, Array]:
    """Ids (n,) below `count`, each once, and corners (n, 4, 2) px, clockwise, of tags in a picture."""
    corners, ids, _ = detector.detectMarkers(grey)
    if ids is None or len(ids) == 0:
        return np.empty(0, dtype=np.int64), np.empty((0, 4, 2))
    numbers = np.asarray(ids).reshape(-1).astype(np.int64)
    values, times = np.unique(numbers, return_counts=True)
    unique = np.isin(numbers, values[times == 1]) & (numbers < count)
    return numbers[unique], np.asarray(corners, dtype=np.float64).reshape(-1, 4, 2)[unique]


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
        ids, places = _corners_of_tags(board, tags, quads)
        corners = refine(grey, board, ids, places)
        # Between the tags nothing moves a corner: there is none.
        if corners is None or len(corners.ids) < 0.8 * len(ids) or _share_unmoved(corners, ids, places) > 0.3:
            continue
        distances[n] = np.median(_local_distances(board, corners.ids, corners.points))
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
    refined = (refine(grey, grid, *_corners_of_tags(grid, *tags)) for grey, tags in shown)
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
