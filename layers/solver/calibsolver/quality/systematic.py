"""Probable causes of systematic residuals: a bent board, motion, a changed focus, a model that is too simple.

Each cause moves the corners of a view in a way of its own: regressors computed from the *predicted*
corners (measured ones have the noise, and would explain all of it). The share that a cause explains is the
adjusted R^2 (Theil 1961) of the residuals of all views, with the pose of each view projected out. Another
model explains the noise that its fit does away with.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .. import deadline, models
from ..arrays import Array
from ..errors import undetermined
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import POSE_SIZE, Poses, linearize
from ..fitting.observations import Observations
from ..view import View
from .assessment import REFERENCE_WIDTH_PX, has_fixed_pattern
from .model_selection import fit_other_models, simplicity_rank

Code = Literal["board_bent", "motion", "focus_changed", "model_too_simple"]

MIN_CAUSE_VIEWS = 3
"""Fewer views fit the intrinsics to a cause."""
MIN_EXPLAINED_SHARE = 0.15
"""Share of the residuals' variance from which a cause is named."""
MIN_SHARE_RATIO = 0.75
"""Share of a cause / the largest one, from which it is named rather than one with more numbers."""
MAX_SHARE_BESIDE_MODEL = 0.5
"""Share of a cause within the views, up to which another model may be to blame."""
MIN_CAUSED_PX = 0.2
"""Rms of what a cause explains, from which a calibration is not good: the noise of corners."""
MIN_CAUSED_INFLATION = 4.0
"""Inflation from which any cause leaves it not good: error bars are twice those of white noise."""
PATTERN_IN_SHAPE = 0.5
"""Limit of the fixed pattern / the usual one, if the board has a shape, which takes up some of it."""
MAX_MODELS_S = 1.0
_NO_MODEL: tuple[str | None, float] = (None, 0.0)
ADVICE: Mapping[Code, str] = {
    "focus_changed": "The focus changed between views: switch autofocus off.",
    "board_bent": "The board bends from view to view: glue it to something rigid, such as glass or a tray.",
    "motion": "The board or the camera moved while a picture was taken: hold it still for longer.",
}
"""Remedies by cause within a view; causes with fewer numbers come first."""


@dataclass(frozen=True)
class Cause:
    """Probable cause of systematic residuals.

    Attributes
    ----------
    share
        Share of the residuals' variance that it explains.
    text
        Remedy.
    px
        Root mean square of the residuals that it explains, px at REFERENCE_WIDTH_PX.
    model
        The model that follows the lens, if this one is too simple.
    """

    code: Code
    share: float
    text: str
    px: float
    inflation: float
    model: str | None = None

    @property
    def is_noticeable(self) -> bool:
        """True if it moves corners by no less than their noise does, or doubles the error bars."""
        return self.px >= MIN_CAUSED_PX or self.inflation >= MIN_CAUSED_INFLATION

    @property
    def is_main(self) -> bool:
        """True if it explains so much that no other model is to blame."""
        return self.share >= MAX_SHARE_BESIDE_MODEL


@undetermined()
def probable_cause(calibration: Calibration, views: Sequence[View]) -> Cause | None:
    """Probable cause of what is systematic in the residuals; None if nothing explains them.

    Motion has six numbers a view, a bend three, the focus one: motion explains much of what the others do,
    not the reverse. So a cause with fewer numbers is named unless another explains clearly more.
    """
    taken = [i for i, used in enumerate(calibration.used) if used.any()]
    if len(taken) < MIN_CAUSE_VIEWS:
        return None
    shares = explained_shares(calibration, views)
    most = max(shares.values())
    model, share = _NO_MODEL
    if most < MAX_SHARE_BESIDE_MODEL:
        model, share = deadline.compute_within(
            MAX_MODELS_S, lambda: _better_model(calibration, views), _NO_MODEL
        )
    most = max(most, share)
    if most < MIN_EXPLAINED_SHARE:
        return None
    errors = np.concatenate([calibration.residuals[i][calibration.used[i]] for i in taken])
    f = calibration.inflation
    rms = float(np.sqrt(2 * np.mean(errors**2))) * REFERENCE_WIDTH_PX / calibration.camera.img_size[0]
    if model is not None and share >= MIN_SHARE_RATIO * most:
        text = f"The lens bends more than the {calibration.camera.model} model can: choose the {model} model."
        return Cause("model_too_simple", share, text, float(np.sqrt(share)) * rms, f, model)
    code = next(name for name in ADVICE if shares[name] >= MIN_SHARE_RATIO * most)
    return Cause(code, shares[code], ADVICE[code], float(np.sqrt(shares[code])) * rms, f)


def _better_model(calibration: Calibration, views: Sequence[View]) -> tuple[str | None, float]:
    """Model with less noise in the used views, and the share of the residuals that it explains.

    Other models are fitted only if all views have the same pattern of errors. Ties go to the simplest.
    """
    bends = calibration.board_shape is not None
    if not has_fixed_pattern(calibration, views, PATTERN_IN_SHAPE if bends else 1.0):
        return _NO_MODEL
    kept = [view for view, used in zip(views, calibration.used, strict=True) if used.any()]
    others, noise = fit_other_models(calibration, kept, bends), max(calibration.noise, 1e-12)
    shares = {name: 1 - (other.noise / noise) ** 2 for name, other in others.items()}
    most = max(shares.values(), default=0.0)
    if most <= 0:
        return _NO_MODEL
    alike = [name for name, share in shares.items() if share >= MIN_SHARE_RATIO * most]
    best = min(alike, key=simplicity_rank)
    return best, shares[best]


def explained_shares(calibration: Calibration, views: Sequence[View]) -> dict[Code, float]:
    """Share of the residuals' variance that each cause within a view explains: adjusted R^2."""
    taken = [i for i, used in enumerate(calibration.used) if used.any()]
    obs = Observations.of(calibration.shaped([views[i] for i in taken]))
    poses = Poses.of_vectors(calibration.poses[taken])
    model, k = models.get(calibration.camera.model), calibration.camera.intrinsics
    q, rows = linearize(model, k, poses, obs.points, 0)
    height = calibration.camera.img_size[1]
    places = obs.points[:, :2].transpose(1, 0, 2)[:, obs.mask]
    middle = places.mean(axis=1)
    scale = np.abs(places - middle[:, None]).max()
    regressions: dict[Code, list[tuple[Array, Array]]] = {code: [] for code in ADVICE}
    for i, view in enumerate(taken):
        used = np.flatnonzero(calibration.used[view])
        j = rows[:, :, i, used]
        if not np.isfinite(j).all():
            continue
        residual = (obs.pixels[i][:, used] - q[:, i, used]).reshape(-1)
        by_pose, by_place = j[model.size :], j[model.size + 3 :]
        x, y = (obs.points[i, :2, used].T - middle[:, None]) / scale
        out_of_plane = np.einsum("kan,k->an", by_place, poses.r[i][:, 2])
        bend = out_of_plane * np.stack([x * x, x * y, y * y])[:, None]
        late = by_pose * (q[1, i, used] / height - 0.5)
        zoom = (k[0] * j[0] + k[1] * j[1])[None]
        basis = np.linalg.qr(_columns(by_pose))[0]
        r = residual - basis @ (basis.T @ residual)
        regressors_of: dict[Code, Array] = {"board_bent": bend, "motion": late, "focus_changed": zoom}
        for code, regressors in regressors_of.items():
            z = _columns(regressors)
            regressions[code].append((r, z - basis @ (basis.T @ z)))
    shares = {code: _share_in_each(views) for code, views in regressions.items()}
    # A board that is bent once and for all needs fewer numbers to explain it.
    shares["board_bent"] = max(shares["board_bent"], _share_in_all(regressions["board_bent"]))
    return shares


def _columns(rows: Array) -> Array:
    """Regressors (m, 2, n) as columns (2n, m) of unit length."""
    flat = rows.reshape(len(rows), -1).T
    return np.asarray(flat / np.maximum(np.linalg.norm(flat, axis=0), 1e-300))


def _share_in_each(views: Sequence[tuple[Array, Array]]) -> float:
    """Adjusted R^2 of least squares in each view separately; 0 if no view has enough points.

    The views' residuals (2n,) and regressors (2n, m) have the pose projected out.
    """
    before = after = 0.0
    freedom = explained = 0
    for r, z in views:
        left = len(r) - POSE_SIZE
        if left <= 2 * z.shape[1]:
            continue
        solved = np.linalg.lstsq(z, r, rcond=1e-6)
        before += float(r @ r)
        after += float(np.sum((r - z @ solved[0]) ** 2))
        freedom += left
        explained += int(solved[2])
    return _adjusted_r_squared(before, after, freedom, explained)


def _share_in_all(views: Sequence[tuple[Array, Array]]) -> float:
    """Adjusted R^2 with the same coefficients in all views."""
    r, z = (np.concatenate(part) for part in zip(*views, strict=True))
    left = r - z @ np.linalg.lstsq(z, r, rcond=1e-6)[0]
    freedom = len(r) - POSE_SIZE * len(views)
    return _adjusted_r_squared(float(r @ r), float(left @ left), freedom, z.shape[1])


def _adjusted_r_squared(before: float, after: float, freedom: int, explained: int) -> float:
    if freedom <= explained or before <= 0:
        return 0.0
    return float(np.clip(1 - after / (freedom - explained) / (before / freedom), 0, 1))
