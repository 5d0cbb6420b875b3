"""Assessment of a calibration: whether it can be trusted, and why not, in plain words."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..camera import pixel_grid
from ..errors import format_px_error, undetermined
from ..fitting.calibration import Calibration
from ..fitting.coverage import Coverage
from ..fitting.normal_equations import Poses
from ..view import View

Level = Literal["good", "fair", "poor"]
Code = Literal[
    "too_few_views",
    "no_tilt",
    "edges_not_covered",
    "left_edge_not_covered",
    "right_edge_not_covered",
    "top_edge_not_covered",
    "bottom_edge_not_covered",
    "uncertain",
    "over_fitted",
    "model_too_simple",
    "board_bent",
    "motion",
    "focus_changed",
    "noisy",
    "outliers",
    "views_left_out",
]
RIM_GRID = (12, 9)
PATTERN_GRID = (8, 6)
EDGES: Mapping[str, tuple[Code, slice | int, slice | int]] = {
    "left": ("left_edge_not_covered", slice(None), 0),
    "right": ("right_edge_not_covered", slice(None), -1),
    "top": ("top_edge_not_covered", 0, slice(None)),
    "bottom": ("bottom_edge_not_covered", -1, slice(None)),
}
"""Code and outermost cells of RIM_GRID, row and column."""
REFERENCE_WIDTH_PX = 1280.0
"""Image width at which lengths in px are meant; they scale with it."""
COVERAGE_RADIUS_DIAGONALS = 0.12
"""Distance / diagonal within which a corner covers its surroundings."""
MIN_NOTICEABLE_PX = 0.1
MAX_GOOD_PX, MAX_FAIR_PX = 1.0, 3.0
"""Largest predicted rms projection error over the image of a good calibration, and of a fair one."""
MAX_FAIR_INSIDE_PX, MIN_FAIR_COVERED = 1.0, 0.1
"""The same of a fair one where the board has been, and smallest share of this part."""
MIN_FITTED_VIEWS = 4
MIN_TILT_DEG = 15.0
"""Below it focal length and distance trade places."""
MIN_RIM_COVERAGE = 0.6
"""Share of the rim, or of a side of it, that has seen corners."""
MAX_HELD_OUT_RATIO, MAX_FAIR_HELD_OUT_RATIO = 1.4, 2.5
"""Largest error on views left out / error on those fitted of a good calibration, and of a fair one."""
MAX_FIXED_PATTERN_SHARE = 0.3
"""Share of the residuals' length that is the same in all views."""
WIDE_MODELS = ("fisheye", "rational", "omnidirectional")
MAX_NOISE_PX = 0.5
MAX_OUTLIER_SHARE = 0.05


@dataclass(frozen=True)
class Reason:
    """Reason why a calibration is not good."""

    code: Code
    text: str


@dataclass(frozen=True)
class Assessment:
    """Verdict and its reasons, the one to act on first."""

    level: Level
    reasons: tuple[Reason, ...]


@undetermined()
def assess(
    calibration: Calibration,
    views: Sequence[View],
    held_out: float | None = None,
    coverage: Coverage | None = None,
) -> Assessment:
    """Judge a calibration by two numbers: its error over the image, and where the board has been.

    What makes them doubtful makes a good calibration fair. `held_out`: px, rms of a cross-validation.
    """
    coverage = coverage or Coverage.of(calibration, views)
    width = calibration.camera.img_size[0]
    scale = width / REFERENCE_WIDTH_PX
    whole = calibration.uncertainty().rms
    level = level_of(whole / scale, coverage.rms / scale, coverage.share)
    doubts = list(_doubts(calibration, views, held_out))
    if any(each == "poor" for each, _ in doubts):
        level = "poor"
    elif level == "good":
        return Assessment("fair" if doubts else "good", tuple(reason for _, reason in doubts))
    # Views that were cut took no part: what they show says nothing of the fit.
    taken = {i: view for i, view in enumerate(views) if i not in calibration.cut_views}
    edge = list(_uncovered_edge(calibration, list(taken.values())))
    is_extrapolated = coverage.rms < whole / 2
    reasons = [*(reason for _, reason in doubts), *_tilt(calibration, taken)]
    if is_extrapolated:
        reasons += edge
    if calibration.noise > MAX_NOISE_PX * scale:
        text = f"corners were found to {calibration.noise:.1f} px only: blur, motion, or a board not flat"
        reasons.append(Reason("noisy", text))
    if not is_extrapolated:
        reasons += edge
    text = f"projections are expected to be {format_px_error(whole, width)}"
    text += f", {format_px_error(coverage.rms, width)} where the board has been: more views would help"
    return Assessment(level, (*reasons, Reason("uncertain", text)))


def level_of(whole: float, inside: float, covered: float) -> Level:
    """Level of predicted errors, px at REFERENCE_WIDTH_PX: over the image, and inside the share `covered`."""
    if whole <= MAX_GOOD_PX:
        return "good"
    is_fair_inside = inside <= MAX_FAIR_INSIDE_PX and covered >= MIN_FAIR_COVERED
    return "fair" if whole <= MAX_FAIR_PX or is_fair_inside else "poor"


def _doubts(
    calibration: Calibration, views: Sequence[View], held_out: float | None
) -> Iterator[tuple[Level, Reason]]:
    """Reasons to doubt the predicted errors, each with the best level that it leaves."""
    width = calibration.camera.img_size[0]
    left_out = len(calibration.cut_views)
    count = len(views) - left_out
    if count < MIN_FITTED_VIEWS:
        text = f"{count} views can agree by chance; {MIN_FITTED_VIEWS} hardly do"
        yield "fair", Reason("too_few_views", text)
    train = calibration.avg_reprojection_error
    least = MIN_NOTICEABLE_PX * width / REFERENCE_WIDTH_PX
    if held_out is not None and held_out > max(train + least, MAX_HELD_OUT_RATIO * train):
        text = f"views left out of the fit are {format_px_error(held_out, width, 2)}"
        level: Level = "poor" if held_out > MAX_FAIR_HELD_OUT_RATIO * train else "fair"
        yield level, Reason("over_fitted", f"{text}, those in it {format_px_error(train, width, 2)}")
    if has_fixed_pattern(calibration, views):
        model, common = calibration.camera.model, fixed_pattern_residual(calibration, views)[1]
        others = [name for name in WIDE_MODELS if name != model]
        text = f"all views err in the same way by {common:.1f} px: the model {model} cannot follow this lens"
        text += f" (choose {', '.join(others[:-1])} or {others[-1]}), or the board is not flat"
        yield "fair", Reason("model_too_simple", text)
    cut = 1 - sum(int(u.sum()) for u in calibration.used) / sum(len(view) for view in views)
    if cut > MAX_OUTLIER_SHARE:
        text = f"{cut:.0%} of the corners contradict the others and were left out"
        yield "fair", Reason("outliers", text)
    if left_out:
        text = f"{left_out} of {len(views)} views contradict the others and were left out"
        yield "poor" if 2 * left_out > len(views) else "fair", Reason("views_left_out", text)


def _tilt(calibration: Calibration, taken: Mapping[int, View]) -> Iterator[Reason]:
    # Angle between the board's normal and the line of sight to its middle.
    poses = Poses.of_vectors(calibration.poses[list(taken)])
    middle = np.stack([view.object_points.mean(axis=0) for view in taken.values()])[:, :, None]
    sight = poses.camera_points(middle)[:, :, 0]
    cosine = np.abs(np.einsum("vi,vi->v", poses.r[:, :, 2], sight)) / np.linalg.norm(sight, axis=1)
    tilt = float(np.degrees(np.arccos(np.clip(cosine, 0, 1)).max()))
    if tilt < MIN_TILT_DEG:
        text = f"the board was never tilted by more than {tilt:.0f} degrees: the focal length is a guess"
        yield Reason("no_tilt", text)


def _uncovered_edge(calibration: Calibration, views: Sequence[View]) -> Iterator[Reason]:
    """Yield the side of the image with the largest error that has not seen the board, or all sides."""
    size = calibration.camera.img_size
    cells = np.moveaxis(pixel_grid(size, RIM_GRID), 0, -1)
    points = np.concatenate([view.image_points for view in views])
    radius = COVERAGE_RADIUS_DIAGONALS * np.hypot(*size)
    shares = {}
    for side, (_, row, column) in EDGES.items():
        distance = np.linalg.norm(cells[row, column][:, None] - points[None], axis=2).min(axis=1)
        shares[side] = float(np.mean(distance < radius))
    missing = [side for side, share in shares.items() if share < MIN_RIM_COVERAGE]
    if len(missing) == len(EDGES):
        text = f"the board came near {np.mean(list(shares.values())):.0%} of the rim of the image"
        yield Reason("edges_not_covered", text)
    elif missing:
        std = calibration.projection_std(RIM_GRID)
        side = max(missing, key=lambda each: float(np.nansum(std[EDGES[each][1:]])))
        yield Reason(EDGES[side][0], f"the {side} edge of the image has not seen the board yet")


def has_fixed_pattern(calibration: Calibration, views: Sequence[View], factor: float = 1.0) -> bool:
    """True if the residuals noticeably depend on the place in the image, alike in all views.

    `factor` multiplies the limits.
    """
    share, common = fixed_pattern_residual(calibration, views)
    least = MIN_NOTICEABLE_PX * calibration.camera.img_size[0] / REFERENCE_WIDTH_PX
    return common > factor * least and share > factor * MAX_FIXED_PATTERN_SHARE


def fixed_pattern_residual(calibration: Calibration, views: Sequence[View]) -> tuple[float, float]:
    """Part of the residuals that depends only on the place in the image: share of their rms, and px rms.

    The mean over a cell of n independent residuals has their variance / n; more than that the model leaves
    unexplained. A bent board shows in each view elsewhere, and counts little.
    """
    (w, h), (columns, rows) = calibration.camera.img_size, PATTERN_GRID
    used = np.concatenate(calibration.used)
    e = np.concatenate(calibration.residuals)[used]
    q = np.concatenate([view.image_points for view in views])[used]
    column = np.clip(((q[:, 0] + 0.5) / w * columns).astype(int), 0, columns - 1)
    row = np.clip(((q[:, 1] + 0.5) / h * rows).astype(int), 0, rows - 1)
    cell = row * columns + column
    cells = columns * rows
    n = np.bincount(cell, minlength=cells)
    total = np.stack([np.bincount(cell, e[:, axis], cells) for axis in (0, 1)])
    enough = n >= 4
    between = float(np.sum(total[:, enough] ** 2 / n[enough]))  # sum of n |mean|^2
    inside = float(np.sum(e**2))
    count, filled = float(n[enough].sum()), int(enough.sum())
    if count <= filled or inside <= 0:
        return 0.0, 0.0
    within = (inside - between) / (len(e) - filled)
    common = max(between - filled * within, 0.0) / count
    return float(np.sqrt(common / (inside / len(e)))), float(np.sqrt(common))
