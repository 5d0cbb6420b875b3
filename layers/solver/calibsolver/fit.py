"""From views to a calibration, or to the reason why there is none."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from . import lm, models, normal, prior, start
from .arrays import Array, frozen, symmetric_inverse
from .calibration import Calibration
from .camera import Camera
from .errors import CalibrationError
from .lm import Options, Problem, State
from .models import Model
from .observations import Observations
from .start import Start
from .uncertainty import sensitivity, weight
from .view import View

MIN_POINTS = 6
"""A view has six unknowns of its own; fewer points say nothing about the camera."""
CUT = 4.0
"""Sigmas beyond which a point is an outlier: one in 3000 good ones."""
ENOUGH = 0.01
"""Many views go without the prior where they alone predict projections to this share of the image width."""
MANY = 8
"""Views from which that holds; fewer keep the prior, which a good capture makes harmless by itself."""
WORST = 0.01
"""A fit whose rms exceeds this share of the image width explains nothing."""
DOUBTFUL = 0.002
"""Above this share of the image width other starts are tried."""
RIM, MOST = 0.01, 0.4
"""Outermost share of the points, and the share of those that bad luck alone does not cut."""
SMOOTH = 4.0
"""Least squares over all points may have this many times the rms of those kept: the model is a little too
simple. More than that, and the points cut were wrong."""
NEAR = 1e-4
"""Relative decrease of the cost below which a stage hands over to the next."""
SURPRISE = 3.0
"""Other starts are tried too where pixels are this many sigmas from square, or the centre from the middle."""


def fit(
    views: Sequence[View], img_size: tuple[int, int], model: str = "rectilinear", robust: bool = True
) -> Calibration:
    """Fit a camera model to views of a planar board.

    Parameters
    ----------
    views
        At least one; each with at least six points that do not lie on a line.
    img_size
        Width and height, px.
    model
        One of `models.NAMES`.
    robust
        Huber weights on the way, then points beyond 4 sigma are cut and the rest fitted by least squares.
        Otherwise plain least squares over all points.

    Raises
    ------
    CalibrationError
        ``no_views``, ``too_few_points``, ``degenerate``, ``not_planar``, ``out_of_range``, ``unknown_model``,
        ``no_fit``, ``not_converged`` or ``not_believable``: never is nonsense returned.
    """
    law = models.get(model)
    check(views, img_size)
    obs = Observations.of(views)
    # Far from the solution numbers may overflow; every step is tested before it is taken.
    with np.errstate(all="ignore"):
        return _Fit(law, obs, img_size, robust).run()


def check(views: Sequence[View], img_size: tuple[int, int]) -> None:
    """Refuse views that no fit could use: CalibrationError, see `fit`."""
    w, h = img_size
    if not (1 < w < 100_000 and 1 < h < 100_000):
        raise CalibrationError("out_of_range", f"an image of {w} x {h} px cannot be calibrated")
    if not views:
        raise CalibrationError("no_views", "there is no view to fit")
    for i, view in enumerate(views):
        if len(view) < MIN_POINTS:
            raise CalibrationError(
                "too_few_points", f"view {i} has {len(view)} points, {MIN_POINTS} are needed"
            )
        p, q = view.object_points, view.image_points
        if np.abs(p).max() > 1e9 or np.abs(q - (w / 2, h / 2)).max() > 10 * max(w, h):
            raise CalibrationError("out_of_range", f"view {i} has points far outside the image or the board")
        if np.ptp(p[:, 2]) > 1e-9 * max(np.ptp(p[:, 0]), np.ptp(p[:, 1])):
            raise CalibrationError("not_planar", f"the points of view {i} do not lie on a board")
        if flatness(p[:, :2]) < 0.02 or flatness(q) < 1e-3 or np.ptp(q, axis=0).max() < 4:
            raise CalibrationError("degenerate", f"the points of view {i} lie on a line or in one place")


def flatness(points: Array) -> float:
    """Smaller over larger principal extent of points (n, 2): 0 where they lie on a line."""
    x, y = (points - points.sum(axis=0) / len(points)).T
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    # Eigenvalues of the 2x2 scatter matrix; the smaller from the determinant, free of cancellation.
    larger = (xx + yy + math.hypot(xx - yy, 2 * xy)) / 2
    return math.sqrt(max(xx * yy - xy * xy, 0.0)) / larger if larger > 0 else 0.0


@dataclass(frozen=True, eq=False)
class _Fit:
    model: Model
    obs: Observations
    img_size: tuple[int, int]
    robust: bool

    @cached_property
    def problem(self) -> Problem:
        return Problem(self.model, self.obs, self.img_size)

    @cached_property
    def everything(self) -> Array:
        """Weight 1 for every point measured, (v, n)."""
        return self.obs.mask.astype(np.float64)

    def run(self) -> Calibration:
        best: State | None = None
        for first in start.ladder(self.model, self.obs, self.img_size)[:4]:
            state = self.converge(first)
            if state is None:
                continue
            if best is None or self.level(state) < self.level(best):
                best = state
            if self.level(best) < DOUBTFUL * self.img_size[0] and self.ordinary(best):
                break
        if best is None:
            raise CalibrationError("no_fit", "no camera explains these views")
        return self.finish(best)

    def level(self, state: State) -> float:
        """Typical residual, px, which a few outliers hardly move."""
        return float(np.mean(state.length[self.obs.mask]))

    def ordinary(self, state: State) -> bool:
        """Whether this is a camera like others; a strange one may be a local minimum beside the right one."""
        return bool(np.abs(state.belief[1:4]).max() < SURPRISE)

    def converge(self, first: Start) -> State | None:
        """From a start to near the optimum with the prior; None where that leads nowhere."""
        if len(first.poses.t) < self.obs.view_count:  # it was tried on some of the views
            first = start.at(self.model, self.obs, first.k)
        state = self.problem.at(first.k, first.poses)
        if not np.isfinite(state.r).all():
            return None
        # The way there is always robust: one bad view must not turn the first steps.
        state = self.problem.solve(state, self.everything, Options(robust=True, tolerance=NEAR))
        return state if np.isfinite(state.r).all() else None

    def finish(self, state: State) -> Calibration:
        """From near the optimum to a result: outliers cut, prior dropped where it may be, least squares."""
        weights, with_prior = self.everything, True
        for _ in range(4 if self.robust else 1):
            if self.robust:
                weights = self.cut(state)
                if self.systematic(weights):
                    whole = self.problem.solve(state, self.everything, Options())
                    if self.rms(whole, self.everything) < SMOOTH * self.rms(state, weights):
                        return replace(self, robust=False).finish(whole)
            state = self.problem.solve(state, weights, Options(tolerance=NEAR))
            with_prior = not self.enough(state, weights)
            state = self.problem.solve(state, weights, Options(with_prior=with_prior))
            if self.robust and np.array_equal(weights, self.cut(state)):
                break
        if not state.converged:
            raise CalibrationError("not_converged", "the fit did not settle: the views contradict each other")
        return self.result(state, weights, with_prior)

    def rms(self, state: State, weights: Array) -> float:
        """Root mean square residual, px, of points of weight (v, n)."""
        return float(np.sqrt(np.sum(weights * state.length**2) / np.sum(weights)))

    def systematic(self, weights: Array) -> bool:
        """Whether the points cut are those at the rim of the image.

        Corners that were found badly lie anywhere. Where the rim is cut it may be the model that fails there,
        and without these points it would fail unseen.
        """
        seen = self.obs.pixels - (np.asarray(self.img_size) / 2)[None, :, None]
        radius = np.where(self.obs.mask, np.hypot(seen[:, 0], seen[:, 1]), 0.0)
        share = max(RIM, min(12 / self.obs.count, 1.0))  # of a few points one or two say nothing
        rim = radius >= np.quantile(radius[self.obs.mask], 1 - share)
        return bool(np.mean(weights[rim] < 1) > MOST)

    def cut(self, state: State) -> Array:
        """Weights (v, n) without the points beyond CUT sigmas."""
        mask = self.everything
        # Beside a view that happens to have less noise, one with as much as others have is no outlier.
        sigma = max(lm.noise(state, mask), lm.FINEST * self.img_size[0])
        # Real residuals have longer tails than the median promises; what is kept says how long.
        for _ in range(3):
            kept = state.length[(state.length <= CUT * sigma) & self.obs.mask]
            sigma = max(sigma, float(np.sqrt(np.mean(kept**2) / 2)))
        weights = np.where(state.length > CUT * sigma, 0.0, mask)
        # A view left with hardly any point keeps a pose by faint weights, and tells next to nothing.
        lost = weights.sum(axis=1) < MIN_POINTS
        weights[lost] = 1e-6 * mask[lost]
        return weights

    def enough(self, state: State, weights: Array) -> bool:
        """Whether the data alone carry every parameter."""
        if self.robust:
            return False
        s = normal.information(state.j, weights).sum(axis=0)
        scale = 1 / np.sqrt(np.maximum(np.diagonal(s), 1e-300))
        if np.linalg.eigvalsh(s * scale[:, None] * scale)[0] < 1e-12:
            return False
        if not self.robust:
            return True  # plain least squares was asked for
        d = sensitivity(self.model, state.k, self.img_size, (10, 8))
        sigma = self.sigma(state, weights)
        predicted = np.sqrt(max(float(np.trace(symmetric_inverse(s) @ weight(d))), 0)) * sigma
        return bool(predicted < ENOUGH * self.img_size[0])

    def sigma(self, state: State, weights: Array) -> float:
        """Noise of one coordinate, px: least squares estimate, corrected for the degrees of freedom."""
        square = float(np.sum(weights * state.length**2))
        used = 2 * float(np.sum(weights))
        free = used - self.model.size - 6 * float(np.sum(weights.sum(axis=1) > 1))
        return float(np.sqrt(square / max(free, 0.1 * used, 1.0)))

    def result(self, state: State, weights: Array, with_prior: bool) -> Calibration:
        k, mask = state.k, self.obs.mask
        square = np.where(mask, state.length**2, 0.0)
        rms = float(np.sqrt(square.sum() / mask.sum()))
        self.believe(state, weights)
        sigma = self.sigma(state, weights)
        s = normal.information(state.j, weights).sum(axis=0)
        if with_prior:
            s = s + max(sigma, 1e-6) ** 2 * prior.information(self.model, k, self.img_size)
        covariance = sigma**2 * symmetric_inverse(s)
        if not (np.isfinite(rms) and np.isfinite(covariance).all()):
            raise CalibrationError("not_believable", "the fit has no finite error")
        return Calibration(
            camera=Camera.from_intrinsics(self.model.name, k, self.img_size),
            poses=frozen(state.poses.vectors()),
            avg_reprojection_error=rms,
            view_errors=frozen(np.sqrt(square.sum(axis=1) / mask.sum(axis=1))),
            covariance=frozen(covariance),
            noise=sigma,
            residuals=tuple(frozen(e[m]) for e, m in zip(state.length, mask, strict=True)),
            used=tuple((w[m] > 1e-3) for w, m in zip(weights, mask, strict=True)),
            prior_used=with_prior,
        )

    def believe(self, state: State, weights: Array) -> None:
        """Refuse a result that no camera could be."""
        k, (w, h) = state.k, self.img_size
        inside = self.obs.mask & (weights > 1e-3)
        if not (np.isfinite(k).all() and np.isfinite(state.r).all()):
            raise CalibrationError("not_believable", "the fit ran away")
        focal = k[:2] * self.model.magnification(k[4:])[0]
        if not (0.05 * w < focal[0] < 50 * w and 0.5 < k[0] / k[1] < 2):
            raise CalibrationError(
                "not_believable", f"a focal length of {focal[0]:.0f}, {focal[1]:.0f} px is no camera's"
            )
        if not (-0.25 * w < k[2] < 1.25 * w and -0.25 * h < k[3] < 1.25 * h):
            raise CalibrationError("not_believable", "the principal point lies far outside the image")
        if inside.sum() < 0.5 * self.obs.mask.sum():
            raise CalibrationError("not_believable", "more than half of the points are outliers")
        level = np.sqrt(np.mean(state.length[inside] ** 2))
        if level > WORST * w:
            raise CalibrationError("not_believable", f"an rms of {level:.1f} px explains nothing")
        p = state.poses.camera_points(self.obs.points).transpose(1, 0, 2)
        folded = ~self.model.valid(k[4:], p) & self.obs.mask
        if folded.sum() > 0.01 * self.obs.mask.sum():
            raise CalibrationError("not_believable", "the distortion folds inside the views")
