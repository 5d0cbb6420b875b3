"""Assessment of a calibration: whether it can be trusted, and why not, in plain words."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .. import models
from ..arrays import Array
from ..camera import pixel_grid
from ..errors import undetermined
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import Poses, project
from ..fitting.observations import Observations
from ..phrasing import format_px_error
from ..view import View

Level = Literal["good", "fair", "poor"]
Code = Literal[
    "too_few_views",
    "no_tilt",
    "edges_not_covered",
    "uncertain",
    "over_fitted",
    "model_too_simple",
    "board_not_flat",
    "board_bent",
    "motion",
    "focus_changed",
    "noisy",
    "outliers",
    "views_left_out",
]

REFERENCE_WIDTH_PX = 1280.0
"""Image width at which the lengths below are meant, px; they scale with it."""
COVERAGE_RADIUS_DIAGONALS = 0.12
"""Of the image's diagonal: how far a corner speaks for its surroundings."""
MIN_NOTICEABLE_PX = 0.1
"""px, differences below which nobody feels."""
# The first of two makes a calibration fair, the second poor.
MIN_FITTED_VIEWS = (4, 2)
MIN_TILT_DEG = (15.0, 5.0)
"""Degrees between sight line and board normal: below it focal length and distance trade places."""
MIN_RIM_COVERAGE = (0.6, 0.2)
"""Share of the rim of the image that has seen corners."""
MAX_UNCERTAINTY_PX = (0.6, 2.0)
"""px, predicted rms projection error."""
MAX_HELD_OUT_RATIO = (1.4, 2.5)
"""Error on views left out / error on those fitted."""
MAX_FIXED_PATTERN_SHARE = 0.3
"""Share of the residuals' length that is the same in all views."""
WIDE_MODELS = ("fisheye", "rational", "omnidirectional")
"""Models for lenses that another cannot follow."""
MAX_NOISE_PX = (0.5, 1.5)
"""px, noise of one coordinate."""
MAX_OUTLIER_SHARE = (0.05, 0.2)
"""Share of the points left out."""


@dataclass(frozen=True)
class Reason:
    """Reason why a calibration is not good: a code for programs, a sentence for people."""

    code: Code
    text: str


@dataclass(frozen=True)
class Assessment:
    """A verdict and what it rests on; no reasons where it is good."""

    level: Level
    reasons: tuple[Reason, ...]


@undetermined()
def assess(calibration: Calibration, views: Sequence[View], held_out: float | None = None) -> Assessment:
    """Judge a calibration by its fit and by its views.

    Parameters
    ----------
    calibration, views
        The fit, and what was fitted.
    held_out
        px, rms of a cross-validation (`cross_validation.held_out`), where there is one.
    """
    found: list[tuple[Level, Reason]] = []

    def note(level: Level, code: Code, text: str) -> None:
        if level != "good":
            found.append((level, Reason(code, text)))

    scale = calibration.camera.img_size[0] / REFERENCE_WIDTH_PX
    left_out = len(calibration.cut_views)
    count = len(views) - left_out
    note(_below(count, MIN_FITTED_VIEWS), "too_few_views", f"{count} views can agree by chance; 4 hardly do")

    # Views that were cut took no part: what they show says nothing of the fit.
    taken = [i for i in range(len(views)) if i not in calibration.cut_views]
    tilt = float(np.degrees(tilts(calibration, views)[taken].max()))
    text = f"the board was never tilted by more than {tilt:.0f} degrees: the focal length is a guess"
    note(_below(tilt, MIN_TILT_DEG), "no_tilt", text)

    seen = rim_covered([views[i] for i in taken], calibration.camera.img_size)
    text = f"the board came near {seen:.0%} of the rim of the image"
    note(_below(seen, MIN_RIM_COVERAGE), "edges_not_covered", text)

    error = calibration.uncertainty().rms
    width = calibration.camera.img_size[0]
    text = f"projections are expected to be {format_px_error(error, width)}: more views would help"
    note(_above(error / scale, MAX_UNCERTAINTY_PX), "uncertain", text)

    train = calibration.avg_reprojection_error
    if held_out is not None and held_out - train > MIN_NOTICEABLE_PX * scale:
        text = f"views left out of the fit are {format_px_error(held_out, width, 2)}"
        text += f", those in it {format_px_error(train, width, 2)}"
        note(_above(held_out / max(train, 1e-12), MAX_HELD_OUT_RATIO), "over_fitted", text)

    if has_fixed_pattern(calibration, views):
        model, common = calibration.camera.model, fixed_pattern_residual(calibration, views)[1]
        others = [name for name in WIDE_MODELS if name != model]
        text = f"all views err in the same way by {common:.1f} px: the model {model} cannot follow this lens"
        text += f" (choose {', '.join(others[:-1])} or {others[-1]}), or the board is not flat"
        note("fair", "model_too_simple", text)

    text = f"corners were found to {calibration.noise:.1f} px only: blur, motion, or a board that is not flat"
    note(_above(calibration.noise / scale, MAX_NOISE_PX), "noisy", text)

    cut = 1 - sum(int(u.sum()) for u in calibration.used) / sum(len(view) for view in views)
    text = f"{cut:.0%} of the corners contradict the others and were left out"
    note(_above(cut, MAX_OUTLIER_SHARE), "outliers", text)
    text = f"{left_out} of {len(views)} views contradict the others and were left out"
    note(_above(left_out, (0, len(views) / 2)), "views_left_out", text)

    level: Level = "good"
    if found:
        level = "poor" if any(each == "poor" for each, _ in found) else "fair"
    return Assessment(level, tuple(reason for _, reason in found))


def _above(value: float, bounds: tuple[float, float]) -> Level:
    fair, poor = bounds
    return "poor" if value > poor else "fair" if value > fair else "good"


def _below(value: float, bounds: tuple[float, float]) -> Level:
    fair, poor = bounds
    return _above(-value, (-fair, -poor))


def residual_vectors(calibration: Calibration, views: Sequence[View]) -> list[Array]:
    """Measured minus predicted pixel of every point: for each view (n, 2), px."""
    obs = Observations.of(views)
    model, k = models.get(calibration.camera.model), calibration.camera.intrinsics
    q = project(model, k, Poses.of_vectors(calibration.poses), obs.points)
    return [(obs.pixels[i] - q[i]).T[obs.mask[i]] for i in range(len(views))]


def tilts(calibration: Calibration, views: Sequence[View]) -> Array:
    """Angle (v,) between each board's normal and the line of sight to its middle, radians."""
    poses = Poses.of_vectors(calibration.poses)
    middle = np.stack([view.object_points.mean(axis=0) for view in views])[:, :, None]
    sight = poses.camera_points(middle)[:, :, 0]
    cosine = np.abs(np.einsum("vi,vi->v", poses.r[:, :, 2], sight)) / np.linalg.norm(sight, axis=1)
    angle: Array = np.arccos(np.clip(cosine, 0, 1))
    return angle


def rim_covered(views: Sequence[View], img_size: tuple[int, int], grid: tuple[int, int] = (12, 9)) -> float:
    """Share of the outermost cells of the image that have a corner near."""
    cells = pixel_grid(img_size, grid)
    rim = np.ones((grid[1], grid[0]), dtype=bool)
    rim[1:-1, 1:-1] = False
    centers = cells[:, rim].T
    points = np.concatenate([view.image_points for view in views])
    distance = np.linalg.norm(centers[:, None] - points[None], axis=2).min(axis=1)
    return float(np.mean(distance < COVERAGE_RADIUS_DIAGONALS * np.hypot(*img_size)))


def has_fixed_pattern(calibration: Calibration, views: Sequence[View]) -> bool:
    """Whether the residuals noticeably depend on the place in the image, alike in all views."""
    share, common = fixed_pattern_residual(calibration, views)
    least = MIN_NOTICEABLE_PX * calibration.camera.img_size[0] / REFERENCE_WIDTH_PX
    return common > least and share > MAX_FIXED_PATTERN_SHARE


def fixed_pattern_residual(
    calibration: Calibration, views: Sequence[View], grid: tuple[int, int] = (8, 6)
) -> tuple[float, float]:
    """Part of the residuals that depends on the place in the image alone: share of their rms, and px rms.

    The mean over a cell of independent residuals has their variance / n; what is more than that the model
    leaves unexplained. A board that is bent shows in each view elsewhere, and counts little.
    """
    w, h = calibration.camera.img_size
    used = np.concatenate(calibration.used)
    e = np.concatenate(residual_vectors(calibration, views))[used]
    q = np.concatenate([view.image_points for view in views])[used]
    column = np.clip(((q[:, 0] + 0.5) / w * grid[0]).astype(int), 0, grid[0] - 1)
    row = np.clip(((q[:, 1] + 0.5) / h * grid[1]).astype(int), 0, grid[1] - 1)
    cell = row * grid[0] + column
    cells = grid[0] * grid[1]
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
