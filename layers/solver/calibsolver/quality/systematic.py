"""Probable causes of systematic residuals: a bent board, motion, a changed focus, a model that is too simple.

Each cause moves the corners of a view in a way of its own: regressors of the residuals, computed from the
*predicted* corners (measured ones hold the noise, and would explain all of it). What a cause explains is the
adjusted R^2 (Theil 1961) of the residuals of all views, with the pose of each view projected out: 0 where it
explains no more than chance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .. import models
from ..arrays import Array
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import POSE_SIZE, Poses, linearize
from ..fitting.observations import Observations
from ..view import View

Code = Literal["board_bent", "motion", "focus_changed"]

MIN_EXPLAINED_SHARE = 0.15
"""Share of the residuals' variance that a cause explains, from which it is named."""
MIN_BEND_RATIO = 0.75
"""Share that a bend explains / share that motion explains, from which it is the bend that is named."""
ADVICE: Mapping[Code, str] = {
    "board_bent": "The board is not flat: glue it to something rigid, such as glass or a tray.",
    "motion": "The board or the camera moved while a picture was taken: hold it still for longer.",
    "focus_changed": "The focus changed between views: switch autofocus off.",
}
"""Advice to the person who holds the board."""


@dataclass(frozen=True)
class Cause:
    """Probable cause of systematic residuals.

    Attributes
    ----------
    code
        For programs.
    share
        Share of the residuals' variance that it explains, 0 to 1.
    text
        What to do about it.
    """

    code: Code
    share: float
    text: str


def probable_cause(calibration: Calibration, views: Sequence[View]) -> Cause | None:
    """Find the probable cause of what is systematic in the residuals; None where nothing explains them.

    Parameters
    ----------
    calibration, views
        The fit, and what was fitted; views that took no part do not count.

    Motion has six numbers a view, a bend three: motion explains much of what a bend does, not the reverse. So
    the bend is named unless motion explains clearly more.
    """
    shares = explained_shares(calibration, views)
    code: Code = max(ADVICE, key=lambda name: shares[name])
    if code == "motion" and shares["board_bent"] > MIN_BEND_RATIO * shares[code]:
        code = "board_bent"
    if shares[code] < MIN_EXPLAINED_SHARE:
        return None
    return Cause(code, shares[code], ADVICE[code])


def explained_shares(calibration: Calibration, views: Sequence[View]) -> dict[Code, float]:
    """Share of the residuals' variance that each cause explains: adjusted R^2."""
    taken = [i for i, used in enumerate(calibration.used) if used.any()]
    obs = Observations.of([views[i] for i in taken])
    poses = Poses.of_vectors(calibration.poses[taken])
    model, k = models.get(calibration.camera.model), calibration.camera.intrinsics
    q, rows = linearize(model, k, poses, obs.points, 0)
    height = calibration.camera.img_size[1]
    middle = obs.points[:, :2].transpose(1, 0, 2)[:, obs.mask].mean(axis=1)
    scale = np.abs(obs.points[:, :2].transpose(1, 0, 2)[:, obs.mask] - middle[:, None]).max()
    fits: dict[Code, _Regression] = {code: _Regression() for code in ADVICE}
    shared = _SharedRegression()
    for i, view in enumerate(taken):
        used = np.flatnonzero(calibration.used[view])
        j = rows[:, :, i, used]
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
            z = z - basis @ (basis.T @ z)
            fits[code].add(r, z)
            if code == "board_bent":
                shared.add(r, z)
    shares = {code: fit.share for code, fit in fits.items()}
    # A board that is bent once and for all needs fewer numbers to explain it.
    shares["board_bent"] = max(shares["board_bent"], shared.share)
    return shares


def _columns(rows: Array) -> Array:
    """Regressors (m, 2, n) as columns (2n, m) of unit length."""
    flat = rows.reshape(len(rows), -1).T
    out: Array = flat / np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
    return out


class _Regression:
    """Least squares in each view by itself: sums of squares before and after, and degrees of freedom."""

    def __init__(self) -> None:
        self.before = self.after = 0.0
        self.freedom = self.explained = 0

    def add(self, r: Array, z: Array) -> None:
        """Add a view: residuals (2n,) and regressors (2n, m), the pose projected out of both."""
        freedom = len(r) - POSE_SIZE
        if freedom <= 2 * z.shape[1]:
            return
        solved = np.linalg.lstsq(z, r, rcond=1e-6)
        left = r - z @ solved[0]
        self.before += float(r @ r)
        self.after += float(left @ left)
        self.freedom += freedom
        self.explained += int(solved[2])

    @property
    def share(self) -> float:
        """Adjusted R^2, 0 where nothing was added."""
        return _adjusted(self.before, self.after, self.freedom, self.explained)


class _SharedRegression:
    """Least squares with the same coefficients in all views."""

    def __init__(self) -> None:
        self.r: list[Array] = []
        self.z: list[Array] = []

    def add(self, r: Array, z: Array) -> None:
        """Add a view: residuals (2n,) and regressors (2n, m), the pose projected out of both."""
        self.r.append(r)
        self.z.append(z)

    @property
    def share(self) -> float:
        """Adjusted R^2."""
        r, z = np.concatenate(self.r), np.concatenate(self.z)
        left = r - z @ np.linalg.lstsq(z, r, rcond=1e-6)[0]
        freedom = len(r) - POSE_SIZE * len(self.r)
        return _adjusted(float(r @ r), float(left @ left), freedom, z.shape[1])


def _adjusted(before: float, after: float, freedom: int, explained: int) -> float:
    if freedom <= explained or before <= 0:
        return 0.0
    return float(np.clip(1 - after / (freedom - explained) / (before / freedom), 0, 1))
