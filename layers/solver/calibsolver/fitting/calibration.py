"""The result of a fit."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from typing import Any

import numpy as np

from .. import models
from ..arrays import Array, Mask, frozen
from ..camera import Camera
from ..view import View
from .board_shape import BoardShape
from .uncertainty import Rivals, Uncertainty, square_errors

BORDER_GRID = (40, 30)
"""Grid whose outermost cells reach the border, where rivals differ most."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera and how well its views are explained.

    Attributes
    ----------
    poses
        (v, 6) rvec|tvec, board -> camera, board units; NaN of a degenerate view.
    avg_reprojection_error
        px, root of the mean square distance over *all* points, as cv2.calibrateCamera reports it, except
        those of degenerate views.
    view_errors
        (v,) px, the same for each view; NaN of a degenerate one.
    covariance
        (p, p) of (fx fy cx cy distortion...), see `robust_covariance` and `focal_profile`.
    information
        (p, p) Fisher information of the intrinsics at white noise, with the prior. 0 in fixed directions.
    noise
        px, standard deviation of one coordinate of a corner, of mean weight.
    inflation
        Variance of the intrinsics / that under white noise of the corners, >= 1.
    residuals
        For each view (n, 2) px, observed minus projected; NaN of a point without a projection.
    used
        For each view (n,) the points that took part in the final fit.
    prior_used
        True if the data were too few to go without the prior.
    cut_views
        Views left out of the fit: index -> reason (``outlier``, ``mirrored``, ``degenerate``).
    board_shape
        Bend and stretch of the board, which poses and residuals refer to; None: as drawn.
    fixed
        Names of the parameters that were not estimated.
    rivals
        Other models' cameras that explain the views as well (`quality.rivals`); None: not looked for.
    """

    camera: Camera
    poses: Array
    avg_reprojection_error: float
    view_errors: Array
    covariance: Array
    information: Array
    noise: float
    inflation: float
    residuals: tuple[Array, ...]
    used: tuple[Mask, ...]
    prior_used: bool
    cut_views: Mapping[int, str] = field(default_factory=dict)
    board_shape: BoardShape | None = None
    fixed: tuple[str, ...] = ()
    rivals: Rivals | None = None

    def shaped(self, views: Sequence[View]) -> list[View]:
        """Views of the same board in its shape."""
        return list(views) if self.board_shape is None else [self.board_shape.apply(v) for v in views]

    def with_degenerate_views(self, views: Sequence[View], degenerate: Mask) -> "Calibration":
        """Calibration of all `views`, from this one of those that are not `degenerate` (v,).

        Points on a line have no pose, so pose and errors of degenerate views are NaN.
        """
        usable = np.flatnonzero(~degenerate)
        poses, errors = np.full((len(views), 6), np.nan), np.full(len(views), np.nan)
        poses[usable], errors[usable] = self.poses, self.view_errors
        residuals: list[Array] = [np.full((len(view), 2), np.nan) for view in views]
        used: list[Mask] = [np.zeros(len(view), dtype=bool) for view in views]
        for i, vectors, inliers in zip(usable, self.residuals, self.used, strict=True):
            residuals[i], used[i] = vectors, inliers
        reasons = {int(usable[i]): reason for i, reason in self.cut_views.items()}
        return replace(
            self,
            poses=frozen(poses),
            view_errors=frozen(errors),
            residuals=tuple(frozen(e) for e in residuals),
            used=tuple(used),
            cut_views=reasons | {int(i): "degenerate" for i in np.flatnonzero(degenerate)},
        )

    @property
    def rms_inliers(self) -> float:
        """px, root of the mean square distance over the points that took part in the final fit."""
        square = [np.sum(r[used] ** 2) for r, used in zip(self.residuals, self.used, strict=True)]
        return float(np.sqrt(np.sum(square) / max(sum(used.sum() for used in self.used), 1)))

    def __repr__(self) -> str:
        camera, (fx, fy, cx, cy) = self.camera, self.camera.intrinsics[:4]
        w, h = camera.img_size
        return (
            f"Calibration({camera.model}, {w}x{h}, fx={fx:.2f}, fy={fy:.2f}, cx={cx:.2f}, cy={cy:.2f}, "
            f"{len(self.used) - len(self.cut_views)} views, rms {self.rms_inliers:.3f} px)"
        )

    def summary(self) -> str:
        """Describe the result in a few lines: intrinsics with standard deviations, errors, views left out."""
        rows = self._facts()
        width = max(len(name) for name, _ in rows)
        return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)

    def _repr_html_(self) -> str:
        cells = (f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in self._facts())
        return f"<table>{''.join(cells)}</table>"

    def _facts(self) -> list[tuple[str, str]]:
        camera, stated = self.camera, self.uncertainty()
        names = ("fx", "fy", "cx", "cy", *models.get(camera.model).coefficients)
        deviations = np.sqrt(np.maximum(np.diagonal(self.covariance), 0))
        digits = (2,) * 4 + (5,) * len(camera.distortion)
        numbers = zip(names, camera.intrinsics, deviations, digits, strict=True)
        w, h = camera.img_size
        used, count = sum(int(u.sum()) for u in self.used), sum(len(u) for u in self.used)
        left_out = Counter(self.cut_views.values())
        reasons = "; left out: " + ", ".join(f"{n} {why}" for why, n in left_out.items()) if left_out else ""
        return [
            *(
                (name, f"{value:.{d}f} ± {sigma:.{d}f}" if sigma > 0 else f"{value:.{d}f} (fixed)")
                for name, value, sigma, d in numbers
            ),
            ("camera", f"{camera.model}, {w} x {h} px"),
            ("views", f"{len(self.used) - len(self.cut_views)} of {len(self.used)}{reasons}"),
            ("corners", f"{used} of {count}"),
            ("rms", f"{self.rms_inliers:.3f} px, {self.avg_reprojection_error:.3f} px of all corners"),
            ("uncertainty", f"{stated.rms:.2f} px rms over the image, {stated.max:.2f} px at most"),
        ]

    def projection_std(self, grid: tuple[int, int] = (20, 15)) -> Array:
        """Predicted error of a projection over the image, px, (rows, columns) for `grid` = (columns, rows).

        At the centre of each cell: root of the trace of the 2x2 covariance of the projection, with the best
        rotation of the camera frame over the grid removed. Outside the hull of the corners with the error if
        a rival is right. NaN outside the model's one-to-one domain.
        """
        square = square_errors(self.camera, self.covariance, grid)
        if self.rivals is not None:
            square = square + self.rivals.square_error(self.camera, grid)
        return np.sqrt(square).reshape(grid[1], grid[0])

    def uncertainty(self, grid: tuple[int, int] = (20, 15)) -> Uncertainty:
        """Predict rms and maximum of |true - estimated projection| over the image, px (`projection_std`)."""
        std = self.projection_std(grid)
        known = np.isfinite(std)
        seen = std[known]
        largest = std if self.rivals is None else self.projection_std(BORDER_GRID)
        if not seen.size:  # not even the middle of the image has a ray: nothing is known
            return Uncertainty(float(max(self.camera.img_size)), float(max(self.camera.img_size)), 0.0)
        return Uncertainty(float(np.sqrt(np.mean(seen**2))), float(np.nanmax(largest)), float(known.mean()))

    def record(self) -> dict[str, Any]:
        """Calibration as plain values, under the names of the published file format."""
        uncertainty, shape = self.uncertainty(), self.board_shape
        return {
            "img_size": list(self.camera.img_size),
            "camera_matrix": self.camera.matrix.tolist(),
            "distortion_coefficients": self.camera.distortion.tolist(),
            "distortion_model": self.camera.model,
            "avg_reprojection_error": self.avg_reprojection_error,
            "uncertainty": {"rms": uncertainty.rms, "max": uncertainty.max},
            "systematic": self.inflation,
            **({} if shape is None else {"board_shape": shape.figures()}),
            **({"fixed": list(self.fixed)} if self.fixed else {}),
        }
