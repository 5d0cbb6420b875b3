"""What all calibrations of one camera agree on."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .. import models
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit, fit_again
from ..fitting.resection import reprojection_score
from ..view import View
from .agreement import FEWEST, compare, groups, sway

Doubt = Literal["too_few", "disagree", "few_contributors"]

FOLDS = 5
"""Parts of a group that are left out in turn."""


SWAY = 0.0004
"""Where contributors are told apart, no two of them may together move the answer by more than this share of
the image's width, half a pixel of 1,280; or, where specimens differ, by `by_chance` times what the others do
beyond their noise."""
SWAY_BY_CHANCE, SWAY_OF_MANY = (3.0, 1.73, 1.23, 0.97, 0.81, 0.7), 5.5
"""How far the two of five, six ... ten contributors that move the middle most do so, over the spread of the
others, in seven of eight sets that differ along one direction by chance; of more, over their number - 2."""
SWAY_OF_FEW = 3.5
"""The same of three or four contributors, over the spread of the tightest majority."""


@dataclass(frozen=True, eq=False)
class Member:
    """One calibration of the camera: its id, whoever counts as its contributor, its views."""

    id: str
    contributor: str
    views: tuple[View, ...]


@dataclass(frozen=True)
class Rule:
    """When a consensus is called reliable.

    Attributes
    ----------
    min_calibrations, min_contributors
        In the largest group that agrees.
    min_share
        Of all calibrations that this group holds. Where contributors are told apart (`min_contributors` of 2
        or more) each of them weighs the same, however many calibrations are theirs: in what is a majority,
        in this share, and nobody has more calibrations in the pooled fit than half of the others have.
    max_focal_spread
        Standard deviation of fx / fx, and of fy / fy, within the group.
    max_center_spread
        Standard deviation of cx / width, and of cy / height.
    max_projection_spread
        Two calibrations agree where their projections differ by less than this, rms over the image after
        the best rotation / image width; and by no more than those around them differ (`agreement.gather`).
    max_harmless_spread
        Differences below this are not looked into: two fifths of the members, all off by it, would move the
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
    reason: Doubt | None
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
    fits: list[tuple[Member, Calibration]] = []
    dropped: dict[str, str] = {}
    failure = CalibrationError("no_members", "there is no calibration to pool")
    for member in members:
        try:
            fits.append((member, fit(member.views, img_size, model)))
        except CalibrationError as error:
            dropped[member.id], failure = error.code, error
    if not fits:
        raise failure
    limits = rule.max_projection_spread * img_size[0], rule.max_harmless_spread * img_size[0]
    weight = weights(members, rule)
    parts = groups([c for _, c in fits], *limits, np.array([weight[m.id] for m, _ in fits]))
    group = [fits[i] for i in parts[0]]
    entering = balanced([member for member, _ in group], rule)
    pooled = fit([view for member in entering for view in member.views], img_size, model)
    errors = without_each(group, pooled.camera) if len(group) > 1 else np.empty(0)
    contributors = len({member.contributor for member, _ in group})
    reason = doubt(group, errors, members, img_size, rule)
    return Consensus(
        calibration=pooled,
        members=tuple(m.id for m, _ in group),
        contributors=contributors,
        reliable=reason is None,
        total=len(members),
        reason=reason,
        groups=tuple(tuple(fits[i][0].id for i in part) for part in parts),
        dropped=dropped,
        spread=apart(pooled, [c for _, c in group]) if len(group) > 1 else math.nan,
        member_errors={m.id: float(e) for (m, _), e in zip(group, errors, strict=False)},
        held_out_error=overall(group, errors) if len(group) > 1 else math.nan,
    )


def doubt(
    group: Sequence[tuple[Member, Calibration]],
    errors: Array,
    members: Sequence[Member],
    img_size: tuple[int, int],
    rule: Rule,
) -> Doubt | None:
    """Why the group among `members` is not reliable; `errors` (m,) px of those in it, held out."""
    if len(members) < rule.min_calibrations:
        return "too_few"
    weight = weights(members, rule)
    share = sum(weight[member.id] for member, _ in group) / sum(weight.values())
    if len(group) < rule.min_calibrations or share < rule.min_share - 1e-9:
        return "disagree"
    own = np.array([c.avg_reprojection_error for _, c in group])
    if len(group) > 1 and (errors > own + rule.max_unexplained * img_size[0]).any():
        return "disagree"
    if not spread_within(group, img_size, rule):
        return "disagree"
    contributors = [member.contributor for member, _ in group]
    if len(set(contributors)) < rule.min_contributors:
        return "few_contributors"
    if rule.min_contributors > 1:
        by_two, core = sway([c for _, c in group], contributors)
        if by_two > max(SWAY * img_size[0], by_chance(len(set(contributors))) * core):
            return "disagree"
    return None


def by_chance(contributors: int) -> float:
    """How far two of so many may move the middle, over the spread of the others."""
    if contributors < FEWEST:
        return SWAY_OF_FEW
    at = contributors - FEWEST
    return SWAY_BY_CHANCE[at] if at < len(SWAY_BY_CHANCE) else SWAY_OF_MANY / (contributors - 2)


def weights(members: Sequence[Member], rule: Rule) -> dict[str, float]:
    """How much each member counts, by id: where contributors are told apart, all of one as much as one."""
    if rule.min_contributors < 2:
        return {member.id: 1.0 for member in members}
    counts = Counter(member.contributor for member in members)
    return {member.id: 1 / counts[member.contributor] for member in members}


def balanced(group: Sequence[Member], rule: Rule) -> list[Member]:
    """Those that enter the pooled fit: of each contributor the first, no more than the median one has."""
    if rule.min_contributors < 2:
        return list(group)
    counts = Counter(member.contributor for member in group)
    most = sorted(counts.values())[(len(counts) - 1) // 2]
    entered: Counter[str] = Counter()
    kept = []
    for member in group:
        entered[member.contributor] += 1
        if entered[member.contributor] <= most:
            kept.append(member)
    return kept


def apart(pooled: Calibration, group: Sequence[Calibration]) -> float:
    """Root mean square over the group of the differences from the pooled projections, px."""
    return float(np.sqrt(np.mean(compare([pooled, *group])[0, 1:] ** 2)))


def overall(group: Sequence[tuple[Member, Calibration]], errors: Array) -> float:
    """Root mean square over all points of the errors (m,) of members, px."""
    points = [sum(len(view) for view in member.views) for member, _ in group]
    return float(np.sqrt(np.average(errors**2, weights=points)))


def spread_within(group: Sequence[tuple[Member, Calibration]], img_size: tuple[int, int], rule: Rule) -> bool:
    """Whether focal lengths and principal points vary no more than the rule allows."""
    k = np.stack([np.concatenate([magnification(c), c.camera.intrinsics[2:4]]) for _, c in group])
    std = k.std(axis=0)
    focal = std[:2] / k[:, :2].mean(axis=0)
    center = std[2:] / np.asarray(img_size)
    return bool((focal < rule.max_focal_spread).all() and (center < rule.max_center_spread).all())


def magnification(calibration: Calibration) -> Array:
    """Px per radian on the axis (2,): fx and fy, whatever else a model's coefficients scale them by.

    The f of an omnidirectional camera is (1 + xi) times that, and xi of a narrow lens is anybody's guess.
    """
    camera = calibration.camera
    _, _, by_p = models.get(camera.model).jacobian(camera.intrinsics, np.array([[0.0], [0.0], [1.0]]))
    return np.array([by_p[0, 0, 0], by_p[1, 1, 0]])


def without_each(group: Sequence[tuple[Member, Calibration]], pooled: Camera) -> Array:
    """Rms (m,), px, of each member's views under intrinsics fitted without it, the poses alone fitted anew.

    With it up to a fifth of the group is left out, so that a large one takes no longer: `FOLDS` fits, each
    from where that of all, `pooled`, ended. Infinite where the others alone give no fit.
    """
    errors = np.full(len(group), np.inf)
    views = [view for member, _ in group for view in member.views]
    of = np.repeat(np.arange(len(group)), [len(member.views) for member, _ in group])
    poses = reprojection_score(pooled, views).poses
    for fold in range(min(FOLDS, len(group))):
        left = range(fold, len(group), FOLDS)
        others = np.flatnonzero(~np.isin(of, left))
        try:
            camera = fit_again([views[i] for i in others], pooled, poses[others]).camera
        except CalibrationError:
            continue
        for i in left:
            errors[i] = reprojection_score(camera, group[i][0].views).rms
    return errors
