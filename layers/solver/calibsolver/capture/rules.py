"""Rules of one guided capture: which views are accepted, which are excluded later, when it ends."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from .. import deadline, models, rotation
from ..board import Board
from ..camera import Camera
from ..errors import format_factor, undetermined
from ..fitting.calibration import Calibration
from ..fitting.coverage import Coverage
from ..fitting.resection import reprojection_score
from ..fitting.uncertainty import Uncertainty
from ..guidance import GUIDES, MIN_NOISE_WIDTHS, IntrinsicsPosterior, PoseSelection
from ..guidance.hints import Placement, largest_difference
from ..guidance.target import TargetPose
from ..quality.cross_validation import MAX_PREDICTION_RATIO, prediction_ratio
from ..view import View
from .admission import Reason, is_posed, is_usable, rejection_reason
from .consistency import MAX_OUTVOTED_VIEWS, Consistency
from .decision import (
    EXCLUDED_MINORITY,
    EXCLUDED_OUTLIER,
    LIMIT_REACHED,
    REFUSAL_HINTS,
    Advice,
    Estimate,
    Exclusion,
    ViewDecision,
    find_better_model,
)
from .ending import MAX_VIEWS, MIN_VIEWS, NO_HISTORY, EndReason, History

MAX_POINTS = 20_000
"""Points of all views with which a capture ends."""
MAX_DETECTOR_NOISE_WIDTHS = 0.75 / 1280
"""Noise of a corner's coordinate / image width; no detector of markers has more."""
MAX_ADVICE_S = MAX_CONFLICT_S = 1.0
"""Times for another model, and for views that conflict with others, if the time is limited."""
MAX_RUNNING_PROGRESS = 0.95
MIN_GAIN_SHARE = 0.2
"""Share of the target's gain from which a view counts as held at the target."""


class Capture:
    """One guided capture without its state, which is the list of views and of those excluded.

    Parameters
    ----------
    target_error
        px, predicted rms projection error over the image at which the capture ends.
    seed
        Initial camera, as others have measured it; fits start there, and it is not part of the result.
    recorded
        All views exist already: the capture does not end at an error or a number of views.
    """

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        guidance: str = "projection-uncertainty",
        target_error: float = 0.3,
        seed: Camera | None = None,
        recorded: bool = False,
    ) -> None:
        if guidance not in GUIDES:
            raise ValueError(f"unknown guidance {guidance!r}")
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model).name
        self.guidance = guidance
        self.target_error = float(target_error)
        self.recorded = recorded
        usable = seed is not None and is_usable(seed, self.model, self.img_size)
        self.seed = seed if usable else None
        self.guide = GUIDES[guidance](board, self.img_size, self.model, self.seed)
        self.consistency = Consistency(self.img_size, self.model, self.seed)
        # Progress is measured from here: the first view brings the error that the prior predicts to some px.
        self._initial_rms = 0.03 * self.img_size[0]
        self._initial_camera = IntrinsicsPosterior.of(self.model, self.img_size, None, self.seed).camera

    def without_seed(self) -> "Capture":
        """Same capture without a seed."""
        return Capture(
            self.board, self.img_size, self.model, self.guidance, self.target_error, None, self.recorded
        )

    def camera(self, estimate: Estimate | None) -> Camera:
        """Camera to draw with: the estimate's, or the initial one."""
        if estimate is None or estimate.calibration is None:
            return self._initial_camera
        return estimate.calibration.camera

    def estimate(
        self,
        views: Sequence[View],
        excluded: Mapping[int, Exclusion] | None = None,
        history: History = NO_HISTORY,
    ) -> Estimate:
        """Fit the views that are not `excluded`; if that fails the estimate has no calibration.

        `history`: course of the capture up to the last of the views.
        """
        excluded = excluded or {}
        active = [i for i in range(len(views)) if i not in excluded]
        calibration = self.consistency.fit([views[i] for i in active])
        if calibration is None:
            return Estimate(None, (None,) * len(views), None, 0.0, None, excluded)
        errors: list[float | None] = [None] * len(views)
        for i, error in zip(active, calibration.view_errors, strict=True):
            errors[i] = float(error)
        for i in excluded:
            error = float(reprojection_score(calibration.camera, [views[i]]).rms)
            errors[i] = error if np.isfinite(error) else None
        # Residuals smaller than any detector's are chance, or copies of one view: they count as its noise.
        factor = max(1.0, MIN_NOISE_WIDTHS * self.img_size[0] / max(calibration.noise, 1e-12))
        stated = calibration.uncertainty()
        u = Uncertainty(stated.rms * factor, stated.max * factor)
        span = np.log(self._initial_rms / self.target_error)
        near = float(np.clip(np.log(self._initial_rms / max(u.rms, 1e-9)) / span, 0, 1)) if span > 0 else 1.0
        progress = max(min(0.95 * near, len(active) / MIN_VIEWS), len(active) / MAX_VIEWS)
        progress = min(progress, MAX_RUNNING_PROGRESS)
        coverage = Coverage.of(calibration, [views[i] for i in active])
        coverage = replace(coverage, rms=coverage.rms * factor)
        estimate = Estimate(calibration, tuple(errors), u, progress, excluded=excluded, coverage=coverage)
        end = self._end_reason(views, estimate, history)
        if end is None:
            return estimate
        advice = (LIMIT_REACHED,) if end == "limit" else ()
        return replace(estimate, progress=1.0, end=end, advice=advice)

    def _end_reason(
        self, views: Sequence[View], estimate: Estimate, history: History, *, is_predicted: bool = True
    ) -> EndReason | None:
        """Reason to end here; `is_predicted`: the last view was as far off as predicted."""
        if self.recorded or estimate.uncertainty is None:
            return None
        active = [view for i, view in enumerate(views) if i not in estimate.excluded]
        stated = estimate.uncertainty.rms
        is_plateau = history.has_plateau(stated, len(active))
        done = stated < self.target_error
        if isinstance(self.guide, PoseSelection):
            done, is_plateau = self.guide.is_done(active), False
        if done and is_predicted and len(active) >= MIN_VIEWS:
            return "target"
        if len(active) >= MAX_VIEWS or sum(map(len, views)) + len(self.board.points) > MAX_POINTS:
            return "limit"
        return "plateau" if is_plateau else None

    @undetermined()
    def reconcile(self, views: Sequence[View], excluded: Mapping[int, Exclusion]) -> Estimate:
        """Decide again which views are consistent, after one was undone, and fit those."""
        keep = [i for i in range(len(views)) if i not in excluded] or [len(views) - 1]
        if not views:
            return self.estimate(views)
        for i in sorted(excluded):
            if i not in keep and self.consistency.is_consistent([views[k] for k in keep], views[i]):
                keep.append(i)
        left_out = {i: excluded.get(i, EXCLUDED_MINORITY) for i in range(len(views)) if i not in keep}
        return self.estimate(views, self._exclude_outliers(views, left_out)).with_cause(views)

    def next_target(
        self,
        views: Sequence[View],
        estimate: Estimate,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Next target pose.

        Targets `skipped` since the last view make it an easier one that differs from them; targets
        `unreached` before limit how hard a pose is asked for.
        """
        active = [view for i, view in enumerate(views) if i not in estimate.excluded]
        return self.guide.next_pose(active, estimate.calibration, skipped, unreached)

    def redraw(self, target: TargetPose, views: Sequence[View], camera: Camera) -> TargetPose:
        """Target with its pixels, as it was chosen after these views by `camera`, the estimate's."""
        drawn = self.guide.camera(views) if isinstance(self.guide, PoseSelection) else camera
        return target.redrawn(self.board, drawn)

    @undetermined()
    def judge(
        self,
        views: Sequence[View],
        target: TargetPose | None,
        view: View,
        excluded: Mapping[int, Exclusion] | None = None,
        quarantined: Sequence[View] = (),
        history: History = NO_HISTORY,
        *,
        explain: bool = True,
    ) -> ViewDecision:
        """Decide whether `view` joins the accepted `views`: it must agree with them and not duplicate one.

        Parameters
        ----------
        target
            None for a recorded view.
        excluded
            Exclusions of accepted views, by index.
        quarantined
            Refused views that were kept (`ViewDecision.quarantine`).
        explain
            False: the estimate has no advice. `explain` adds it later, once for several recorded views.
        """
        with np.errstate(all="ignore"):  # hostile numbers end in a refusal, not in a warning
            return self._judge(views, target, view, excluded or {}, quarantined, history, explain=explain)

    def _judge(
        self,
        views: Sequence[View],
        target: TargetPose | None,
        view: View,
        excluded: Mapping[int, Exclusion],
        quarantined: Sequence[View],
        history: History,
        *,
        explain: bool,
    ) -> ViewDecision:
        excluded_before = excluded
        reason = rejection_reason(view, self.img_size)
        if reason is not None:
            return self._refuse(reason, view, target)
        if self.seed is not None and not views and not is_posed(self.seed, view):
            fresh = self.without_seed()
            first = None if target is None else fresh.next_target([], fresh.estimate([]))
            return replace(fresh.judge([], first, view, explain=explain), seed_rejected=True)
        others = [views[i] for i in range(len(views)) if i not in excluded]
        before = self.consistency.fit(others)
        gain = IntrinsicsPosterior.of(self.model, self.img_size, before, self.seed).view_gain(view)
        if gain is None:
            return self._refuse("outlier", view, target)
        all_views = [*views, view]
        if not self.consistency.is_consistent(others, view):
            resolve = partial(self._resolve_conflict, views, view, excluded, quarantined)
            resolved = deadline.compute_within(MAX_CONFLICT_S, resolve, None)
            if resolved is None:
                quarantine = bool(others) and self.consistency.is_consistent([], view)
                return replace(self._refuse("outlier", view, target), quarantine=quarantine)
            excluded = resolved
        elif target is not None and (refusal := self._redundancy(target, others, view)):
            return self._refuse(refusal, view, target, before)
        on_target = None
        if target is not None:
            on_target = isinstance(self.guide, PoseSelection) or gain >= MIN_GAIN_SHARE * target.gain
        left_out = self._exclude_outliers(all_views, excluded)
        history = history.with_view(bool(on_target))
        estimate = self.estimate(all_views, left_out, history)
        if estimate.calibration is None or len(views) in left_out:
            return self._refuse("outlier", view, target)
        if explain:
            estimate = self._check_prediction(all_views, estimate, before, excluded_before, history)
            estimate = estimate.with_cause(all_views)
        return ViewDecision(True, None, estimate, on_target=on_target)

    def explain(self, views: Sequence[View], estimate: Estimate) -> Estimate:
        """Add advice to an estimate of recorded `views`, the last of which was just judged without it."""
        active = [view for i, view in enumerate(views[:-1]) if i not in estimate.excluded]
        before = self.consistency.fit(active)
        return self._check_prediction(views, estimate, before, {}, NO_HISTORY, every=1).with_cause(views)

    def _check_prediction(
        self,
        views: Sequence[View],
        estimate: Estimate,
        before: Calibration | None,
        excluded_before: Mapping[int, Exclusion],
        history: History,
        every: int = MIN_VIEWS,
    ) -> Estimate:
        """Continue the capture if the error of the last view differs from the predicted one.

        Then, and if views are newly excluded, and if the corners are far noisier than any detector's
        (after `every` so many views), the model may be too simple: others are tried.
        """
        calibration, last = estimate.calibration, len(views) - 1
        if before is None or calibration is None or isinstance(self.guide, PoseSelection):
            return estimate
        count = len(views) - len(estimate.excluded)
        ratio = 1.0
        if last not in estimate.excluded:
            ratio = prediction_ratio(
                before, views[-1], calibration.used[-1], MIN_NOISE_WIDTHS * self.img_size[0]
            )
        noisy = calibration.noise > MAX_DETECTOR_NOISE_WIDTHS * self.img_size[0] and count % every == 0
        disagrees = ratio > MAX_PREDICTION_RATIO
        if not (disagrees or noisy or len(estimate.excluded) > len(excluded_before)):
            return estimate
        better = deadline.compute_within(MAX_ADVICE_S, partial(find_better_model, views, calibration), None)
        advice = list(estimate.advice)
        if disagrees:
            text = f"The last view lies {format_factor(ratio)} as far off as was predicted"
            text += "; more views will tell."
            advice.append(Advice("prediction_disagrees", text))
        if better is not None:
            text = f"This lens bends more than the model can; {better} explains it better."
            advice.append(Advice("model_too_simple", text))
        estimate = replace(estimate, advice=tuple(advice), suggested_model=better)
        if not disagrees or estimate.end != "target":
            return estimate
        end = self._end_reason(views, estimate, history, is_predicted=False)
        return replace(estimate, end=end, progress=estimate.progress if end else MAX_RUNNING_PROGRESS)

    def _resolve_conflict(
        self,
        views: Sequence[View],
        view: View,
        excluded: Mapping[int, Exclusion],
        quarantined: Sequence[View],
    ) -> dict[int, Exclusion] | None:
        """Exclusions of `views` that let `view` stay; None if `view` itself is wrong."""
        active = [i for i in range(len(views)) if i not in excluded]
        if not active or not self.consistency.is_consistent([], view):
            return None
        wrong = self.consistency.find_conflicting_view([views[i] for i in active], view)
        if wrong is not None:
            return {**excluded, active[wrong]: EXCLUDED_OUTLIER}
        outvoted = min(len(active), MAX_OUTVOTED_VIEWS)
        group = self.consistency.find_consistent_views(view, [*quarantined, *views], outvoted)
        if len(group) <= outvoted:
            return None
        members = {id(member) for member in group}
        return {
            i: excluded.get(i, EXCLUDED_MINORITY) for i, other in enumerate(views) if id(other) not in members
        }

    def _exclude_outliers(
        self, views: Sequence[View], excluded: Mapping[int, Exclusion]
    ) -> dict[int, Exclusion]:
        result = dict(excluded)
        while True:
            active = [i for i in range(len(views)) if i not in result]
            find = partial(self.consistency.find_outlier_view, [views[i] for i in active])
            wrong = deadline.compute_within(MAX_CONFLICT_S, find, None)
            if wrong is None:
                return result
            result[active[wrong]] = EXCLUDED_OUTLIER

    def _redundancy(self, target: TargetPose, others: Sequence[View], view: View) -> Reason | None:
        if isinstance(self.guide, PoseSelection):  # the published method accepts views that reach its target
            return None if self.guide.is_reached(target, view) else "no_information"
        return "duplicate" if any(self.consistency.is_same_pose(view, other) for other in others) else None

    def _refuse(
        self, reason: Reason, view: View, target: TargetPose | None, before: Calibration | None = None
    ) -> ViewDecision:
        if reason in REFUSAL_HINTS or target is None:
            return ViewDecision(False, reason, None, REFUSAL_HINTS.get(reason))
        camera = before.camera if before else self._initial_camera
        pose = reprojection_score(camera, [view]).poses[0]
        actual = Placement.of(self.board, camera, rotation.matrix(pose[:3]), pose[3:])
        placement = Placement.of(self.board, camera, target.r, target.tvec)
        return ViewDecision(False, reason, None, largest_difference(actual, placement, self.img_size[0]))
