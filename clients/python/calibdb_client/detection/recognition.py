"""Recognition of the board that pictures show.

Markers name their dictionary. Their numbers, row by row, fit the lattice of one number of columns only, of
one kind of board and one layout; their size in the lattice is the ratio to the squares. A board without
markers is a chessboard, whose corners OpenCV counts.
"""

import statistics
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calibsolver.arrays import Array

from ..board import DICTIONARIES, Board, opencv
from ..errors import MirroredError, UsageError
from .aprilgrid import estimate_spacing
from .chessboard import count_corners
from .detector import grey_of
from .markers import Key, Markers, find_markers

MAX_LOOKED_AT = 8
MAX_SEARCHED = 3
"""Pictures of these, and families of markers, that are tried; more would say the same."""
MAX_SIDE_PX = 1600
"""Longer side of a picture in which a board is looked for; larger ones are shrunk."""
MIN_MARKERS = 5
"""Markers of a picture whose numbers say how the board is laid out."""
MAX_RESIDUAL = 0.12
"""Mean distance of markers from their lattice / its pitch, far ones counted as one."""
MAX_TRIALS = 50
"""Sets of four markers by which a layout is tried: few of them are false."""
MIN_LEAD = 2.0
"""Residual of the second best layout / that of the best."""
MAX_COLUMNS = 50
USUAL_RATIOS = (0.5, 0.6, 0.65, 0.7, 0.75, 0.8)
MAX_RATIO_OFFSET = 0.02
"""Difference from a usual marker ratio up to which that is meant."""


@dataclass(frozen=True)
class Layout:
    """Layout of numbered markers on a board with `columns` of squares or tags.

    `first`: the first cell of a checkered layout has a marker; None: every cell has one, from the bottom.
    """

    columns: int
    first: bool | None

    def cells(self, ids: Any) -> Array:
        """Columns and rows (n, 2) of markers; rows of an AprilGrid are negative: it is numbered upwards."""
        if self.first is None:
            row, column = np.divmod(ids, self.columns)
            return np.stack([column, -row], axis=1).astype(np.float64)
        # Two rows hold as many markers as a row has squares.
        upper = (self.columns + self.first) // 2
        pair, rest = np.divmod(ids, self.columns)
        lower = rest >= upper
        column = np.where(lower, 2 * (rest - upper) + self.first, 2 * rest + (not self.first))
        return np.stack([column, 2 * pair + lower], axis=1).astype(np.float64)


def recognise(pictures: Iterable[Any], mirrored: bool = False) -> Board | None:
    """Return the board in pictures (h, w) or (h, w, 3), 8 bits; None if they show none, or do not tell.

    `mirrored` pictures are turned back. Raises MirroredError if the pictures are mirrored, CaptureError if
    they differ on the number of squares, MissingPackageError without OpenCV.
    """
    greys = []
    for picture in pictures:
        grey = _shrunk(grey_of(picture))
        greys.append(opencv().flip(grey, 1) if mirrored else grey)
        if len(greys) == MAX_LOOKED_AT:
            break
    markers_of_images = [find_markers(grey) for grey in greys]
    if any(len(each.ids) >= MIN_MARKERS for markers in markers_of_images for each in markers.values()):
        return _with_markers(markers_of_images, greys)  # never as the chessboard that its squares are
    return _chessboard(greys)


def _with_markers(markers_of_images: Sequence[Mapping[Key, Markers]], greys: Sequence[Any]) -> Board | None:
    families: Counter[Key] = Counter()
    for each in markers_of_images:
        families.update({key: len(markers.ids) for key, markers in each.items()})
    for key, _ in families.most_common(MAX_SEARCHED):
        shown = [each[key] for each in markers_of_images if key in each]
        matches = [markers for markers in shown if len(markers.ids) >= MIN_MARKERS]
        matches.sort(key=lambda markers: -len(markers.ids))
        if matches and (layout := _layout(matches[:MAX_SEARCHED])):
            family, inverted, mirrored = key
            if mirrored:
                raise MirroredError
            return _board(layout, family, inverted, matches, greys)
    return None


def _layout(markers: Sequence[Markers]) -> Layout | None:
    """Return the layout that the markers fit, if it is certain."""
    scores: list[tuple[float, Layout]] = []
    last = max(int(each.ids.max()) for each in markers)
    for first in (False, True, None):
        rows = 2 if first is None else 1  # at least two are seen, so that there are no more columns than that
        for columns in range(2 if first is None else 3, min(MAX_COLUMNS, last * 2 // rows + 1) + 1):
            layout = Layout(columns, first)
            residuals = [r for each in markers if (r := _fit(layout, each)[0]) is not None]
            if residuals:
                scores.append((statistics.median(residuals), layout))
    scores.sort(key=lambda each: each[0])
    if not scores or scores[0][0] > MAX_RESIDUAL:
        return None
    if len(scores) > 1 and scores[1][0] < MIN_LEAD * scores[0][0]:
        return None
    return scores[0][1]


def _fit(layout: Layout, markers: Markers) -> tuple[float | None, Any]:
    """Return the residual, pitches, of markers in a layout, and the homography to its cells; None: no fit."""
    cells = layout.cells(markers.ids) + 0.5
    if np.linalg.matrix_rank(cells - cells.mean(axis=0), tol=0.5) < 2:
        return None, None
    middles = markers.corners.mean(axis=1)
    matrix, _ = opencv().findHomography(middles, cells, opencv().RANSAC, MAX_RESIDUAL, maxIters=MAX_TRIALS)
    if matrix is None:
        return None, None
    placed = opencv().perspectiveTransform(middles[None], matrix)[0]
    # Board and picture are both seen from before: a layout that mirrors one of them is wrong.
    if np.linalg.det(matrix) < 0 or not np.isfinite(placed).all():
        return None, None
    return float(np.minimum(np.linalg.norm(placed - cells, axis=1), 1.0).mean()), matrix


def _board(
    layout: Layout, family: str, inverted: bool, markers: Sequence[Markers], greys: Sequence[Any]
) -> Board | None:
    side = statistics.median(side for each in markers for side in _sides(layout, each))
    rows = max(int(np.abs(layout.cells(each.ids)[:, 1]).max()) for each in markers) + 1
    try:
        if layout.first is None:
            grid = Board((layout.columns, rows), 0.65, family, False, "aprilgrid", inverted, 1 / side - 1)
            spacing = estimate_spacing(grid, greys)
            return None if spacing is None else replace(grid, tag_spacing=spacing)
        rows = max(rows, 3)
        if layout.first and rows % 2:  # the old layout differs where the number of rows is even
            rows += 1
        dictionary = _smallest(family, layout.columns * rows // 2)
        ratio = min(USUAL_RATIOS, key=lambda each: abs(each - side))
        if abs(ratio - side) > MAX_RATIO_OFFSET:
            ratio = round(side, 2)
        return Board((layout.columns, rows), ratio, dictionary, layout.first, inverted=inverted)
    except UsageError:
        return None


def _sides(layout: Layout, markers: Markers) -> list[float]:
    _, matrix = _fit(layout, markers)
    if matrix is None:
        return []
    corners = opencv().perspectiveTransform(markers.corners.reshape(1, -1, 2), matrix).reshape(-1, 4, 2)
    lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    return [float(each) for each in lengths.mean(axis=1)]


def _smallest(family: str, count: int) -> str:
    """Return the smallest dictionary of a family with so many markers: fewer are mistaken for others."""
    stem = family.removesuffix("_1000")
    smaller = [n for n in (50, 100, 250) if f"{stem}_{n}" in DICTIONARIES and count <= n]
    return f"{stem}_{smaller[0]}" if stem != family and smaller else family


def _chessboard(greys: Sequence[Any]) -> Board | None:
    """Return the chessboard in most pictures.

    One that is white on black is the same board turned by half a turn, or gives the same intrinsics.
    """
    size = count_corners(greys)
    if size is None:
        return None
    try:
        return Board((size[0] + 1, size[1] + 1), kind="chessboard")
    except UsageError:
        return None


def _shrunk(grey: Any) -> Any:
    factor = MAX_SIDE_PX / max(grey.shape)
    if factor >= 1:
        return grey
    return opencv().resize(grey, None, fx=factor, fy=factor, interpolation=opencv().INTER_AREA)
