"""The rules of one guided capture."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from .. import models, rotation
from ..board import Board
from ..camera import Camera
from ..fitting import initial_guess, normal_equations
from ..fitting.calibration import Calibration
from ..fitting.observations import Observations
from ..fitting.resection import score
from ..fitting.uncertainty import Uncertainty
from ..guidance import GUIDES, LEAST_NOISE, Belief, PoseSelection
from ..guidance.hints import Hint, Placement, between
from ..guidance.target import TargetPose
from ..quality.prediction import DISAGREEMENT, surprise
from ..view import View
from .admission import Reason, unfit
from .advice import LIMIT, Advice, disagreement, suggestion
from .consistency import PATIENCE, Consistency
from .decision import DISAGREES, OUTLIER, Estimate, SetAside, Verdict

__all__ = ["MAX_VIEWS", "Advice", "Capture", "Estimate", "Hint", "Reason", "SetAside", "Verdict"]

MIN_VIEWS = 4
"""Fewer views can agree by chance."""
MAX_VIEWS = 15
"""Where a capture ends with what was reached."""
WILD = 0.15
"""Median error / image width of a view with its pose alone fitted, that no lens explains."""
NOISY = 0.75 / 1280
"""Noise of a corner's coordinate / image width that no detector has, in a picture that shows markers."""
CAUTION = 1.1
"""Times the predicted error that is reported and aimed at."""
LEAST_SHARE = 0.2
"""Of the gain predicted for the target that a view must bring."""


class Capture:
    """One guided capture: everything but its state, which is the list of views and which are set aside.

    Parameters
    ----------
    board, img_size, model
        What is captured with what; width and height in px.
    guidance
        One of `guidance.GUIDES`.
    target_error
        px, predicted rms projection error over the image at which the capture ends.
    prior
        The camera as others have measured it: the first estimate, and no part of the result.
    """

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        guidance: str = "projection-uncertainty",
        target_error: float = 0.3,
        prior: Camera | None = None,
    ) -> None:
        if guidance not in GUIDES:
            raise ValueError(f"unknown guidance {guidance!r}")
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model).name
        self.target_error = float(target_error)
        self.prior = prior if prior is not None and self._usable(prior) else None
        self.guide = GUIDES[guidance](board, self.img_size, self.model, self.prior)
        self.trial = Consistency(self.img_size, self.model, self.prior)
        # One view brings the prior down to some px; before it there is nothing to show.
        self._unknown = 0.03 * self.img_size[0]
        self._first_camera = Belief.of(self.model, self.img_size, None, self.prior).camera

    def _usable(self, prior: Camera) -> bool:
        """Whether a first estimate from elsewhere is one: of this model and size, and a camera at all."""
        (w, h), k = self.img_size, prior.intrinsics
        if (prior.model, prior.img_size) != (self.model, self.img_size) or not np.isfinite(k).all():
            return False
        return bool(0.1 * w < k[0] < 20 * w and abs(k[2] - w / 2) < w / 4 and abs(k[3] - h / 2) < h / 4)

    def camera(self, estimate: Estimate | None) -> Camera:
        """Return the camera to draw with: the estimate's, or the prior's where there is none."""
        if estimate is None or estimate.calibration is None:
            return self._first_camera
        return estimate.calibration.camera

    def estimate(self, views: Sequence[View], aside: Mapping[int, SetAside] | None = None) -> Estimate:
        """Fit the views that are not set `aside`; nothing is raised where that fails."""
        aside = aside or {}
        active = [i for i in range(len(views)) if i not in aside]
        calibration = self.trial.fit([views[i] for i in active])
        if calibration is None:
            return Estimate(None, (None,) * len(views), None, 0.0, False, aside)
        errors: list[float | None] = [None] * len(views)
        for i, error in zip(active, calibration.view_errors, strict=True):
            errors[i] = float(error)
        for i in aside:
            errors[i] = self._error(calibration.camera, views[i])
        u = self._uncertainty(calibration)
        sure = u.rms < self.target_error
        if isinstance(self.guide, PoseSelection):
            sure = self.guide.done([views[i] for i in active])
        full = len(active) >= MAX_VIEWS
        converged = (sure and len(active) >= MIN_VIEWS) or full
        span = np.log(self._unknown / self.target_error)
        near = float(np.clip(np.log(self._unknown / max(u.rms, 1e-9)) / span, 0, 1)) if span > 0 else 1.0
        progress = 1.0 if converged else min(0.95 * near, len(active) / MIN_VIEWS, 0.95)
        advice = (LIMIT,) if full and not sure else ()
        return Estimate(calibration, tuple(errors), u, progress, converged, aside, advice)

    def settle(self, views: Sequence[View], aside: Mapping[int, SetAside]) -> Estimate:
        """Decide anew which views belong together, after one was undone, and fit those."""
        keep = [i for i in range(len(views)) if i not in aside] or [len(views) - 1]
        if not views:
            return self.estimate(views)
        for i in sorted(aside):
            if i not in keep and self.trial.belongs([views[k] for k in keep], views[i]):
                keep.append(i)
        left = {i: aside.get(i, DISAGREES) for i in range(len(views)) if i not in keep}
        return self.estimate(views, self._weeded(views, left))

    def next_target(
        self,
        views: Sequence[View],
        estimate: Estimate,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Choose where to hold the board next.

        Where targets were `skipped` since the last view, unlike them and easier; from those `unreached`
        before it is learnt what to ask for.
        """
        active = [view for i, view in enumerate(views) if i not in estimate.aside]
        return self.guide.next_pose(active, estimate.calibration, skipped, unreached)

    def judge(
        self,
        views: Sequence[View],
        target: TargetPose,
        view: View,
        aside: Mapping[int, SetAside] | None = None,
        doubted: Sequence[View] = (),
    ) -> Verdict:
        """Decide whether `view` joins the accepted `views`.

        Parameters
        ----------
        target
            What was asked for.
        aside
            Those of the `views` that were set aside: index -> why.
        doubted
            Views refused before that are worth keeping (`Verdict.witness`).
        """
        aside = dict(aside or {})
        reason = unfit(view, self.img_size)
        if reason is not None:
            return self._refused(reason, view, target)
        with np.errstate(all="ignore"):  # hostile numbers end in a refusal, not in a warning
            return self._judged(list(views), target, view, aside, doubted)

    def _judged(
        self,
        views: list[View],
        target: TargetPose,
        view: View,
        aside: dict[int, SetAside],
        doubted: Sequence[View],
    ) -> Verdict:
        active = [i for i in range(len(views)) if i not in aside]
        others = [views[i] for i in active]
        before = self.trial.fit(others)
        gain = self._gain(before, view)
        if gain is None:
            return self._refused("outlier", view, target)
        everything, asked = [*views, view], dict(aside)
        if not self.trial.belongs(others, view):
            changed = self._contradiction(views, active, view, aside, doubted)
            if changed is None:
                alone = bool(others) and self.trial.belongs([], view)
                return replace(self._refused("outlier", view, target), witness=alone)
            aside = changed
        elif not self._enough(target, view, gain):
            return self._refused("no_information", view, target, before)
        estimate = self.estimate(everything, self._weeded(everything, aside))
        if estimate.calibration is None:
            return self._refused("outlier", view, target)
        return Verdict(True, None, self._checked(everything, estimate, before, asked))

    def _contradiction(
        self,
        views: Sequence[View],
        active: Sequence[int],
        view: View,
        aside: Mapping[int, SetAside],
        doubted: Sequence[View],
    ) -> dict[int, SetAside] | None:
        """Return who is set aside so that `view` can stay, or None where it is the view that is wrong."""
        if not active or not self.trial.belongs([], view):
            return None
        wrong = self.trial.culprit([views[i] for i in active], view)
        if wrong is not None:
            return {**aside, active[wrong]: OUTLIER}
        group = self.trial.group(view, [*doubted, *views])
        if len(group) <= min(len(active), PATIENCE):
            return None
        members = {id(member) for member in group}
        return {i: aside.get(i, DISAGREES) for i, other in enumerate(views) if id(other) not in members}

    def _weeded(self, views: Sequence[View], aside: Mapping[int, SetAside]) -> dict[int, SetAside]:
        """Return `aside` and the views that, by now, do not belong to the others."""
        left = dict(aside)
        while True:
            active = [i for i in range(len(views)) if i not in left]
            wrong = self.trial.misfit([views[i] for i in active])
            if wrong is None:
                return left
            left[active[wrong]] = OUTLIER

    def _checked(
        self,
        views: Sequence[View],
        estimate: Estimate,
        before: Calibration | None,
        known: Mapping[int, SetAside],
    ) -> Estimate:
        """Hold the last view against what was predicted of it: where that was wrong the capture goes on.

        There, where views fall out (`known` did before), and where the corners are far noisier than any
        detector's, it may be the model that fails: others are tried.
        """
        calibration, last = estimate.calibration, len(views) - 1
        if before is None or calibration is None or isinstance(self.guide, PoseSelection):
            return estimate
        count = len(views) - len(estimate.aside)
        off = 1.0
        if last not in estimate.aside:
            off = surprise(before, views[-1], calibration.used[-1], LEAST_NOISE * self.img_size[0])
        noisy = calibration.noise > NOISY * self.img_size[0] and count % MIN_VIEWS == 0
        wrong = off > DISAGREEMENT
        if not (wrong or noisy or len(estimate.aside) > len(known)):
            return estimate
        better = suggestion(views, calibration)
        advice = (*estimate.advice, *disagreement(off if wrong else None, better))
        estimate = replace(estimate, advice=advice, suggested_model=better)
        if not wrong or count >= MAX_VIEWS:
            return estimate
        return replace(estimate, converged=False, progress=min(estimate.progress, 0.95))

    def _enough(self, target: TargetPose, view: View, gain: float) -> bool:
        """Whether a view that is right is also worth having."""
        if isinstance(self.guide, PoseSelection):
            return self.guide.reached(target, view)
        return gain >= LEAST_SHARE * target.gain

    def _uncertainty(self, calibration: Calibration) -> Uncertainty:
        """Predicted error; residuals below what any detector reaches are luck, or copies of one view.

        CAUTION on top: views chosen for a small prediction make it rather too small than too large.
        """
        u = calibration.uncertainty()
        luck = CAUTION * max(1.0, LEAST_NOISE * self.img_size[0] / max(calibration.noise, 1e-12))
        return Uncertainty(u.rms * luck, u.max * luck)

    def _gain(self, before: Calibration | None, view: View) -> float | None:
        """px^2 that the view brings, by what was known before it; None where it cannot be posed."""
        belief = Belief.of(self.model, self.img_size, before, self.prior)
        obs = Observations.of([view])
        posed = initial_guess.at(belief.model, obs, belief.k)
        if not posed.error < WILD * self.img_size[0]:
            return None
        q, j = normal_equations.design(belief.model, belief.k, posed.poses, obs.points)
        if not (np.isfinite(q).all() and np.isfinite(j).all()):
            return None
        return belief.gain(normal_equations.information(j, obs.mask.astype(np.float64))[0])

    def _error(self, camera: Camera, view: View) -> float | None:
        error = float(score(camera, [view]).view_errors[0])
        return error if np.isfinite(error) else None

    def _refused(
        self, reason: Reason, view: View, target: TargetPose, before: Calibration | None = None
    ) -> Verdict:
        """Refuse, and say what to do."""
        fixed: dict[Reason, Hint] = {
            "too_few_points": Hint.of("show_more"),
            "degenerate": Hint.of("closer"),
            "mirrored": Hint.of("unmirror"),
            "outlier": Hint.of("hold_still"),
        }
        if reason in fixed:
            return Verdict(False, reason, None, fixed[reason])
        camera = before.camera if before else self._first_camera
        pose = score(camera, [view]).poses[0]
        goal = rotation.matrix(target.rvec)
        seen = Placement.of(self.board, camera, rotation.matrix(pose[:3]), pose[3:])
        wanted = Placement.of(self.board, camera, goal, target.tvec)
        return Verdict(False, reason, None, between(seen, wanted, self.img_size[0]))
