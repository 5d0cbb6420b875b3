"""Pooling of the calibrations of one camera into a consensus, and the rule by which it is reliable."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit, refine
from ..fitting.resection import reprojection_score
from ..fitting.validation import check, degenerate_views, pack
from ..view import View
from .agreement import MIN_LEAVE_TWO_OUT_CONTRIBUTORS, compare, leave_two_out_influence, split_into_groups

UnreliableReason = Literal["too_few", "disagree", "few_contributors"]

FOLDS = 5
"""Parts of a group that are left out in turn."""
MAX_INFLUENCE_WIDTHS = 0.0004
"""Leave-two-out influence on the answer / image width, where contributors are told apart: half a pixel of
1,280; or, where specimens differ, `null_quantile` times the others' spread beyond their noise."""
NULL_QUANTILES, NULL_QUANTILE_SCALE = (3.0, 1.73, 1.23, 0.97, 0.81, 0.7), 5.5
"""Leave-two-out influence / spread of the others that seven of eight honest sets do not exceed by chance.

The sets differ along one direction, and have five, six ... ten contributors; for larger ones the quantile
is the scale / (contributors - 2)."""
SMALL_SAMPLE_NULL_QUANTILE = 3.5
"""The same of three or four contributors, over the spread of the densest majority."""


@dataclass(frozen=True, eq=False)
class Member:
    """Views of one calibration of the camera, with the ids of the calibration and of its contributor."""

    id: str
    contributor: str
    views: tuple[View, ...]


@dataclass(frozen=True, eq=False)
class Fitted:
    """A member and the calibration fitted to its views."""

    member: Member
    calibration: Calibration


@dataclass(frozen=True)
class Rule:
    """Thresholds from which a consensus is called reliable.

    Attributes
    ----------
    min_calibrations, min_contributors
        In the largest group that agrees.
    min_share
        Share of all calibrations that this group holds. Where contributors are told apart (`min_contributors`
        of 2 or more) each of them weighs the same, however many calibrations are theirs, in majorities and
        in this share; and nobody has more calibrations in the pooled fit than half of the others have.
    max_focal_spread
        Standard deviation of fx / fx, and of fy / fy, within the group.
    max_center_spread
        Standard deviation of cx / width, and of cy / height.
    max_projection_spread
        Two calibrations agree where their projections differ by less than this, rms over the image after
        the best rotation / image width; and by no more than those around them (`agreement.forward_search`).
    max_harmless_spread
        Differences below this are accepted: two fifths of the members, all off by it, would move the
        pooled projections by less than half a pixel of 1,280.
    max_unexplained
        A member's views, its poses fitted to the others' intrinsics, may have an rms above that of its own
        fit by this / image width.
    """

    min_calibrations: int = 5
    min_contributors: int = 1
    min_share: float = 0.6
    max_focal_spread: float = 0.05
    max_center_spread: float = 0.02
    max_projection_spread: float = 0.01
    max_harmless_spread: float = 0.0006
    max_unexplained: float = 0.004


@dataclass(frozen=True, eq=False)
class Consensus:
    """The largest group of calibrations that agree.

    Attributes
    ----------
    calibration
        One set of intrinsics fitted to all views of the group.
    members
        Ids of the group, in the order given.
    contributors
        Number of different contributors in the group.
    reliable
        Whether the rule holds.
    total
        Number of all calibrations.
    reason
        Why it is not reliable; None where it is.
    groups
        Ids of the members of every group that agrees, largest first: modes of the camera, or mistakes.
    dropped
        Members whose views the model cannot be fitted to: id -> code of the `CalibrationError`.
    spread
        px, root mean square over the image and over the group of the difference between a member's own
        projections and the pooled ones, after the best rotation; NaN where there is one member.
    member_errors
        px rms of the views of each of the group under intrinsics fitted to the others, by id; empty where
        there are no others.
    held_out_error
        px, root mean square of those over all points; NaN where there are no others.
    """

    calibration: Calibration
    members: tuple[str, ...]
    contributors: int
    reliable: bool
    total: int
    reason: UnreliableReason | None
    groups: tuple[tuple[str, ...], ...]
    dropped: Mapping[str, str]
    spread: float
    member_errors: Mapping[str, float]
    held_out_error: float


def pool(
    members: Sequence[Member], img_size: tuple[int, int], model: str, rule: Rule | None = None
) -> Consensus:
    """Pool the calibrations of one camera.

    Raises CalibrationError (``no_members``, or what `fit` raises) where nothing believable comes out.
    """
    rule = rule or Rule()
    fits: list[Fitted] = []
    dropped: dict[str, str] = {}
    failure = CalibrationError("no_members", "there is no calibration to pool")
    for member in members:
        try:
            member = replace(member, views=without_degenerate_views(member.views, img_size))
            fits.append(Fitted(member, fit(member.views, img_size, model)))
        except CalibrationError as error:
            dropped[member.id], failure = error.code, error
    if not fits:
        raise failure
    limits = rule.max_projection_spread * img_size[0], rule.max_harmless_spread * img_size[0]
    weights = member_weights(members, rule)
    groups = [
        [fits[i] for i in indices]
        for indices in split_into_groups(
            [f.calibration for f in fits], *limits, np.array([weights[f.member.id] for f in fits])
        )
    ]
    group = groups[0]
    entering = balance_contributors([f.member for f in group], rule)
    pooled = fit([view for member in entering for view in member.views], img_size, model)
    errors = cross_validate_members(group, pooled.camera) if len(group) > 1 else np.empty(0)
    reason = unreliable_reason(group, errors, members, img_size, rule)
    return Consensus(
        calibration=pooled,
        members=tuple(f.member.id for f in group),
        contributors=len({f.member.contributor for f in group}),
        reliable=reason is None,
        total=len(members),
        reason=reason,
        groups=tuple(tuple(f.member.id for f in part) for part in groups),
        dropped=dropped,
        spread=rms_spread(pooled, [f.calibration for f in group]) if len(group) > 1 else math.nan,
        member_errors={f.member.id: float(e) for f, e in zip(group, errors, strict=False)},
        held_out_error=pooled_rms(group, errors) if len(group) > 1 else math.nan,
    )


def without_degenerate_views(views: Sequence[View], img_size: tuple[int, int]) -> tuple[View, ...]:
    """Set aside the views whose points lie on a line or in one place.

    Raises CalibrationError as `fit` does, ``degenerate`` where no view is left.
    """
    degenerate = degenerate_views(pack(views, img_size))
    if degenerate.all():
        check(views, img_size)  # raises
    return tuple(view for view, flat in zip(views, degenerate, strict=True) if not flat)


def unreliable_reason(
    group: Sequence[Fitted],
    errors: Array,
    members: Sequence[Member],
    img_size: tuple[int, int],
    rule: Rule,
) -> UnreliableReason | None:
    """Reason why the group among all `members` is not reliable; None where it is.

    Parameters
    ----------
    errors
        (m,) px rms of the group's members, each held out; empty where the group is one member.
    """
    if len(members) < rule.min_calibrations:
        return "too_few"
    weights = member_weights(members, rule)
    share = sum(weights[f.member.id] for f in group) / sum(weights.values())
    if len(group) < rule.min_calibrations or share < rule.min_share - 1e-9:
        return "disagree"
    own = np.array([f.calibration.avg_reprojection_error for f in group])
    if len(group) > 1 and (errors > own + rule.max_unexplained * img_size[0]).any():
        return "disagree"
    if not is_spread_within(group, img_size, rule):
        return "disagree"
    contributors = [f.member.contributor for f in group]
    if len(set(contributors)) < rule.min_contributors:
        return "few_contributors"
    if rule.min_contributors > 1:
        influence, spread = leave_two_out_influence([f.calibration for f in group], contributors)
        by_chance = null_quantile(len(set(contributors))) * spread
        if influence > max(MAX_INFLUENCE_WIDTHS * img_size[0], by_chance):
            return "disagree"
    return None


def null_quantile(contributors: int) -> float:
    """Quantile 7/8 of the leave-two-out influence of so many honest contributors / spread of the others."""
    if contributors < MIN_LEAVE_TWO_OUT_CONTRIBUTORS:
        return SMALL_SAMPLE_NULL_QUANTILE
    i = contributors - MIN_LEAVE_TWO_OUT_CONTRIBUTORS
    return NULL_QUANTILES[i] if i < len(NULL_QUANTILES) else NULL_QUANTILE_SCALE / (contributors - 2)


def member_weights(members: Sequence[Member], rule: Rule) -> dict[str, float]:
    """Weight of each member by id: where contributors are told apart, those of one share a weight of 1."""
    if rule.min_contributors < 2:
        return {member.id: 1.0 for member in members}
    counts = Counter(member.contributor for member in members)
    return {member.id: 1 / counts[member.contributor] for member in members}


def balance_contributors(group: Sequence[Member], rule: Rule) -> list[Member]:
    """Select the members for the pooled fit: each contributor's first ones, no more than the median count."""
    if rule.min_contributors < 2:
        return list(group)
    counts = Counter(member.contributor for member in group)
    median = sorted(counts.values())[(len(counts) - 1) // 2]
    entered: Counter[str] = Counter()
    selected = []
    for member in group:
        entered[member.contributor] += 1
        if entered[member.contributor] <= median:
            selected.append(member)
    return selected


def rms_spread(pooled: Calibration, group: Sequence[Calibration]) -> float:
    """Root mean square over the group of the differences from the pooled projections, px."""
    return float(np.sqrt(np.mean(compare([pooled, *group])[0, 1:] ** 2)))


def pooled_rms(group: Sequence[Fitted], errors: Array) -> float:
    """Root mean square over all points of the errors (m,) of members, px."""
    points = [sum(len(view) for view in f.member.views) for f in group]
    return float(np.sqrt(np.average(errors**2, weights=points)))


def is_spread_within(group: Sequence[Fitted], img_size: tuple[int, int], rule: Rule) -> bool:
    """Whether focal lengths, px per radian at the axis, and principal points vary no more than allowed."""
    cameras = [f.calibration.camera for f in group]
    k = np.stack([[*camera.focal, *camera.intrinsics[2:4]] for camera in cameras])
    std = k.std(axis=0)
    focal = std[:2] / k[:, :2].mean(axis=0)
    center = std[2:] / np.asarray(img_size)
    return bool((focal < rule.max_focal_spread).all() and (center < rule.max_center_spread).all())


def cross_validate_members(group: Sequence[Fitted], pooled: Camera) -> Array:
    """Rms (m,), px, of each member's views under intrinsics fitted without it, the poses alone fitted anew.

    At most FOLDS fits, each from where that of all, `pooled`, ended: with a member up to a fifth of the group
    is left out, so that a large group takes no longer. Infinite where the others alone give no fit.
    """
    errors = np.full(len(group), np.inf)
    views = [view for f in group for view in f.member.views]
    owner = np.repeat(np.arange(len(group)), [len(f.member.views) for f in group])
    poses = reprojection_score(pooled, views).poses
    for fold in range(min(FOLDS, len(group))):
        held_out = range(fold, len(group), FOLDS)
        others = np.flatnonzero(~np.isin(owner, held_out))
        try:
            camera = refine([views[i] for i in others], pooled, poses[others]).camera
        except CalibrationError:
            continue
        for i in held_out:
            errors[i] = reprojection_score(camera, group[i].member.views).rms
    return errors
