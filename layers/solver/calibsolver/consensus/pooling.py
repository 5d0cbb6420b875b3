"""Pooling of the calibrations of one camera into a consensus, and the rule by which it is reliable."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ..arrays import Array, IntArray, Mask, frozen, symmetric_inverse
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.calibration import Calibration
from ..fitting.coverage import Coverage
from ..fitting.fit import fit, refine
from ..fitting.resection import MIN_POSE_POINTS, reprojection_score
from ..fitting.validation import check, degenerate_views, pack
from ..rotation import matrix
from .agreement import Estimates, differences, settle, split_into_groups
from .fit_memory import fit_once
from .location import Contributions, FittedMember, Member, number_owners

__all__ = ["Consensus", "Member", "Rule", "pool"]

FOLDS = 5
UnreliableReason = Literal["too_few", "disagree", "few_contributors", "imprecise"]

MAX_STATED_WIDTHS = 1.5 / 1280
"""Largest error / image width of a reliable consensus where its boards have been."""
MIN_INFLUENCE_LIMIT_WIDTHS = 0.5 / 1280
"""Shift of the answer / image width that two contributors may cause, however much they differ."""
MAX_INFLUENCE_WIDTHS = 1 / 1280
MAX_INFLUENCE_ON_FIVE_WIDTHS = 1.25 / 1280
"""Shift of the answer / image width that two contributors may cause at most, of many and of up to five."""
INFLUENCE_PER_SPREAD = 3.5
"""Shift that two contributors may cause / spread of the densest majority, between those limits."""


@dataclass(frozen=True)
class Rule:
    """Thresholds from which a consensus is called reliable.

    Attributes
    ----------
    min_calibrations, min_contributors
        Minimum numbers in the largest agreeing group.
    min_share
        Share of all calibrations in this group. If contributors are distinguished (`min_contributors` of 2 or
        more) each of them weighs the same in majorities and in this share.
    max_unexplained
        Rms of a member's views, its poses fitted to the others' intrinsics, above that of its own fit / image
        width.
    """

    min_calibrations: int = 5
    min_contributors: int = 1
    min_share: float = 0.6
    max_unexplained: float = 0.004


@dataclass(frozen=True, eq=False)
class Consensus:
    """The largest group of calibrations that agree.

    Attributes
    ----------
    calibration
        One set of intrinsics fitted to all views of the group.
    coverage
        Part of the image that the group's boards have shown, and the error stated there.
    members
        Ids of the group, in the order given.
    contributors
        Number of different contributors in the group, of the largest family.
    reliable, reason
        True if the rule is met, or the reason why not.
    total
        Number of all calibrations.
    consistent
        True if the rule would be met if one calibration were enough.
    groups
        Ids of the members of every group that agrees, largest first: modes of the camera, or mistakes.
    dropped
        Members that cannot be fitted: id -> code of the `CalibrationError`.
    spread
        px rms over the image and the group, of the members' own projections from the pooled ones.
    member_errors
        px rms of the views of each of the group under intrinsics fitted to the others, by id.
    held_out_error
        px rms of those over all points. It and `spread` are NaN of one member.
    """

    calibration: Calibration
    coverage: Coverage
    members: tuple[str, ...]
    contributors: int
    reliable: bool
    total: int
    reason: UnreliableReason | None
    consistent: bool
    groups: tuple[tuple[str, ...], ...]
    dropped: Mapping[str, str]
    spread: float
    member_errors: Mapping[str, float]
    held_out_error: float


@undetermined()
def pool(
    members: Sequence[Member], img_size: tuple[int, int], model: str, rule: Rule | None = None
) -> Consensus:
    """Pool the calibrations of one camera.

    Raises CalibrationError ``no_members``, or as `fit` does if no member can be fitted.
    """
    rule = rule or Rule()
    fits: list[FittedMember] = []
    dropped: dict[str, str] = {}
    failure = CalibrationError("no_members", "there is no calibration to pool")
    for member in members:
        try:
            fits.append(_fit_member(member, img_size, model))
        except CalibrationError as error:
            dropped[member.id], failure = error.code, error
    if not fits:
        raise failure
    agreement = _Agreement(fits, rule)
    indices = agreement.groups[0]
    group = [fits[i] for i in indices]
    shares = _weights(group, rule)
    located = None
    if rule.min_contributors > 1 and len(group) > 1:
        located = locate_contributors(indices, agreement)
    if located is not None:
        pooled, errors, is_stable = located
    else:
        pooled = fit_views(group, img_size, model)
        errors = cross_validate_views(group, pooled.camera) if len(group) > 1 else np.empty(0)
        is_stable = rule.min_contributors < 2
    coverage = Coverage.of(pooled, [view for f in group for view in f.member.views])
    any_number = replace(rule, min_calibrations=1)
    reason, remaining = (
        unreliable_reason(group, errors, members, coverage, r, is_stable=is_stable)
        for r in (rule, any_number)
    )
    return Consensus(
        calibration=pooled,
        coverage=coverage,
        members=tuple(f.member.id for f in group),
        contributors=count_contributors(group),
        reliable=reason is None,
        total=len(members),
        reason=reason,
        consistent=remaining is None,
        groups=tuple(tuple(fits[i].member.id for i in part) for part in agreement.groups),
        dropped=dropped,
        spread=_weighted_rms(
            differences([pooled.camera, *(f.calibration.camera for f in group)])[0, 1:], shares
        ),
        member_errors={f.member.id: float(e) for f, e in zip(group, errors, strict=False)},
        held_out_error=_weighted_rms(errors, shares),
    )


def _fit_member(member: Member, img_size: tuple[int, int], model: str) -> FittedMember:
    """Fit a member's views, without degenerate ones; they then show its board in its shape.

    Raises as `fit` does.
    """
    degenerate = degenerate_views(pack(member.views, img_size))
    if degenerate.all():
        check(member.views, img_size)  # raises
    views = tuple(view for view, flat in zip(member.views, degenerate, strict=True) if not flat)
    calibration = fit_once(views, img_size, model)
    shaped = tuple(calibration.shaped(views))
    pack(shaped, img_size)  # or it is not a board
    return FittedMember(replace(member, views=shaped), calibration)


def locate_contributors(
    indices: Sequence[int], agreement: "_Agreement"
) -> tuple[Calibration, Array, bool] | None:
    """Calibration at the location of a group's contributors, held-out errors (m,), and stability.

    None if the views do not determine a common camera.
    """
    group = [agreement.fits[i] for i in indices]
    try:
        contributions = agreement.contributions
        pooled = fit_location(indices, contributions)
    except CalibrationError:
        return None
    own = np.sqrt(np.mean([f.calibration.avg_reprojection_error**2 for f in group]))
    width = pooled.camera.img_size[0]
    if not pooled.avg_reprojection_error < own + agreement.rule.max_unexplained * width:
        return None
    errors = cross_validate_contributors(indices, contributions)
    influence = contributions.leave_out_influence(indices, agreement.regroup)
    contributors = len({f.member.contributor for f in group})
    spread = contributions.majority_spread(indices)
    return pooled, errors, influence <= max_influence(contributors, spread, width)


class _Agreement:
    """Agreement of the members of one camera under a rule."""

    def __init__(self, fits: Sequence[FittedMember], rule: Rule) -> None:
        self.fits = fits
        self.rule = rule
        calibrations = [f.calibration for f in fits]
        owner = number_owners(
            [f.member.contributor if rule.min_contributors > 1 else f.member.id for f in fits]
        )
        self.estimates = Estimates.of(calibrations, owner, medoid([c.camera for c in calibrations]))
        self.groups = split_into_groups(self.estimates, _weights(fits, rule))

    @cached_property
    def contributions(self) -> Contributions:
        """Members' views, linearized about the location of the largest group."""
        group = self.groups[0]
        members = [self.fits[i] for i in group]
        camera = medoid([f.calibration.camera for f in members])
        try:
            result = Contributions(self.fits, camera).relinearize(group)
        except CalibrationError:
            result = None
        if result is not None and result.length(result.locate(group).y) < result.huber_px:
            return result
        # One calibration may lie far along a valley of the model; all of them together do not.
        pooled = fit_views(members, camera.img_size, camera.model)
        return Contributions(self.fits, pooled.camera).relinearize(group)

    def regroup(self, indices: IntArray) -> IntArray:
        """Group among some members (indices): those of the largest group, and others that agree with them."""
        remaining = np.intersect1d(indices, self.groups[0])
        return settle(self.estimates, remaining, indices) if remaining.size else remaining


def medoid(cameras: Sequence[Camera]) -> Camera:
    """Camera whose projections lie closest to those of all the others."""
    away = np.minimum(differences(cameras), 1e9).sum(axis=1)
    return cameras[int(np.argmin(away))]


def unreliable_reason(
    group: Sequence[FittedMember],
    errors: Array,
    members: Sequence[Member],
    coverage: Coverage,
    rule: Rule,
    *,
    is_stable: bool,
) -> UnreliableReason | None:
    """Reason why the group among all `members` is not reliable; None if it is.

    `errors` (m,) are px rms of the held-out members, `is_stable` if two contributors move the result by no
    more than allowed.
    """
    if len(members) < rule.min_calibrations:
        return "too_few"
    weights = member_weights(members, rule)
    share = sum(weights[f.member.id] for f in group) / sum(weights.values())
    if len(group) < rule.min_calibrations or share < rule.min_share - 1e-9:
        return "disagree"
    width = group[0].calibration.camera.img_size[0]
    own = np.array([f.calibration.avg_reprojection_error for f in group])
    if len(group) > 1 and (errors > own + rule.max_unexplained * width).any():
        return "disagree"
    if count_contributors(group) < rule.min_contributors:
        return "few_contributors"
    if not coverage.rms <= MAX_STATED_WIDTHS * width:
        return "imprecise"
    return None if is_stable else "disagree"


def count_contributors(group: Sequence[FittedMember]) -> int:
    """Number of a group's contributors of the largest family."""
    different = {(f.member.family, f.member.contributor) for f in group}
    return max(Counter(family for family, _ in different).values())


def max_influence(contributors: int, spread: float, width: int) -> float:
    """Shift of the answer, px rms, that two of so many contributors may cause.

    If the densest majority, of standard deviation `spread` (px), agrees closely, a larger shift is a mistake,
    or a lie.
    """
    most = MAX_INFLUENCE_ON_FIVE_WIDTHS if contributors <= 5 else MAX_INFLUENCE_WIDTHS
    return min(max(INFLUENCE_PER_SPREAD * spread, MIN_INFLUENCE_LIMIT_WIDTHS * width), most * width)


def member_weights(members: Sequence[Member], rule: Rule) -> dict[str, float]:
    """Weight of each member by id: if contributors are distinguished, those of one share a weight of 1."""
    if rule.min_contributors < 2:
        return {member.id: 1.0 for member in members}
    counts = Counter(member.contributor for member in members)
    return {member.id: 1 / counts[member.contributor] for member in members}


def _weighted_rms(errors: Array, weights: Array) -> float:
    """Weighted root mean square; NaN of one member."""
    return float(np.sqrt(np.average(errors**2, weights=weights))) if len(weights) > 1 else math.nan


def _weights(fits: Sequence[FittedMember], rule: Rule) -> Array:
    weights = member_weights([f.member for f in fits], rule)
    return np.array([weights[f.member.id] for f in fits])


def fit_views(group: Sequence[FittedMember], img_size: tuple[int, int], model: str) -> Calibration:
    """Fit one camera to the views of all members of a group; raises as `fit` does."""
    if len(group) == 1:
        return group[0].calibration  # which is just that
    return fit([view for f in group for view in f.member.views], img_size, model, board_shape=False)


def fit_location(group: Sequence[int], of: Contributions) -> Calibration:
    """Pooled fit: the camera at the location of a group's contributors."""
    location = of.locate(group)
    return describe(of.camera_at(location), [of.fitted[i] for i in group], of.covariance(group, location))


def describe(camera: Camera, group: Sequence[FittedMember], covariance: Array) -> Calibration:
    """Describe a camera by the views of a group: poses by their inliers, errors over all points."""
    views = [view for f in group for view in f.member.views]
    used = [mask for f in group for mask in f.calibration.used]
    shown = [
        view.subset(mask) if mask.sum() >= MIN_POSE_POINTS else view
        for view, mask in zip(views, used, strict=True)
    ]
    posed = reprojection_score(camera, shown).poses
    limit = float(np.hypot(*camera.img_size))
    residuals = [
        view.image_points - camera.project(view.object_points @ matrix(pose[:3]).T + pose[3:])
        for view, pose in zip(views, posed, strict=True)
    ]
    lengths = [np.fmin(np.linalg.norm(e, axis=1), limit) for e in residuals]  # of NaN the limit
    square = [float(np.sum(e**2)) for e in lengths]
    points = [len(e) for e in lengths]
    noise = np.sqrt(np.mean([f.calibration.noise**2 for f in group]))
    weights = [sum(map(len, f.member.views)) for f in group]
    return Calibration(
        camera=camera,
        poses=frozen(posed),
        avg_reprojection_error=float(np.sqrt(sum(square) / sum(points))),
        view_errors=frozen(np.sqrt(np.divide(square, points))),
        covariance=frozen(covariance),
        information=frozen(symmetric_inverse(covariance)),
        noise=float(noise),
        inflation=float(np.average([f.calibration.inflation for f in group], weights=weights)),
        residuals=tuple(frozen(e) for e in residuals),
        used=tuple(used),
        prior_used=any(f.calibration.prior_used for f in group),
    )


def cross_validate_views(group: Sequence[FittedMember], pooled: Camera) -> Array:
    """Rms (m,), px, of each member's views under intrinsics fitted without it, from the `pooled` camera.

    In at most FOLDS fits, so that a large group takes no longer. Infinite if the others give no fit.
    """
    views = [view for f in group for view in f.member.views]
    owner = np.repeat(np.arange(len(group)), [len(f.member.views) for f in group])
    poses = reprojection_score(pooled, views).poses

    def fit_without(out: Mask) -> Camera:
        others = np.flatnonzero(~out[owner])
        return refine([views[i] for i in others], pooled, poses[others]).camera

    return _held_out_errors(group, np.arange(len(group)), fit_without)


def cross_validate_contributors(group: Sequence[int], of: Contributions) -> Array:
    """Rms (m,), px, of each member's views under the location of other contributors.

    Of a single contributor, its calibrations are left out in turn.
    """
    members: IntArray = np.asarray(group, dtype=np.int64)
    numbers, part = np.unique(of.owner[members], return_inverse=True)
    if len(numbers) < 2:
        part = np.arange(len(members))
    return _held_out_errors(
        [of.fitted[i] for i in group], part, lambda out: of.camera_at(of.locate(members[~out]))
    )


def _held_out_errors(
    group: Sequence[FittedMember], part: IntArray, fit_without: Callable[[Mask], Camera]
) -> Array:
    errors = np.full(len(group), np.inf)
    for fold in range(min(FOLDS, int(part.max()) + 1)):
        out = part % FOLDS == fold
        try:
            camera = fit_without(out)
        except CalibrationError:
            continue
        for i in np.flatnonzero(out).tolist():
            errors[i] = reprojection_score(camera, group[i].member.views).rms
    return errors
