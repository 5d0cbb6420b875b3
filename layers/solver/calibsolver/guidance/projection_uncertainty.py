"""Next-best view by projection uncertainty: the pose that reduces the projection error over the image most.

A view adds its Fisher information S to that of the intrinsics; the mean square projection error over the
image is trace(covariance W) (`uncertainty.image_error_metric`). The idea of choosing views by expected
error is AprilCal's (Richardson, Strom, Olson, IROS 2013) and Calibration Wizard's (Peng, Sturm, ICCV
2019); the measure, the error over the image up to a rotation, is mrcal's.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from .. import rotation
from ..arrays import Array, symmetric_inverse
from ..board import Board
from ..errors import undetermined
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import Poses
from ..view import View
from . import candidates
from .candidates import CornerGrid, PoseLimits
from .hints import Placement
from .posterior import IntrinsicsPosterior
from .search import PoseHistory, Search, fisher_information
from .target import Guide, TargetPose

NO_LIMITS = PoseLimits(min_visible=0.0, max_incidence_deg=90.0, min_spacing=0.0)
MIN_CORNERS = 8
"""Corners that a target shows: a hand misses a pose by some."""
WHOLE_BORDER = 0.05
"""`PoseLimits.border` if all of the board must be found."""
EASY_LIMITS = PoseLimits(width=(0.45, 0.75), max_tilt_deg=30.0, max_roll_deg=15.0, min_visible=1.0)
"""For a user who could not reach the last target."""
TIE_RATIO = 1.02
"""Score / best score of poses that count as equally good: the nearest to the last pose is chosen."""
MAX_PAIRED_VIEWS = 2
"""Views before which the next one and the one after it are chosen together."""
MAX_DISTANCE_LENGTHS = 3.0
"""Distance of the board / its length, unless the lens is too long for it."""


class ProjectionUncertainty(Guide):
    """The default guidance. `seed`: the intrinsics before the first view, as others have measured them."""

    @cached_property
    def _corners(self) -> CornerGrid:
        return CornerGrid.of(self.board, None)

    @undetermined()
    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Choose the pose of the next view.

        Parameters
        ----------
        views
            Only their number matters: it varies the choice between equally good poses.
        calibration
            The estimate from them, or None.
        skipped
            Targets the user could not reach: one unlike them is chosen, easy to hold and wholly visible.
        unreached
            Targets given up earlier: from then on easier ones are chosen.
        """
        posterior = IntrinsicsPosterior.of(self.model.name, self.img_size, calibration, self.seed)
        # First estimates may be far off: corners that overflow count as invisible.
        with np.errstate(all="ignore"):
            if not views and not skipped:
                return self.first_pose(posterior)
            history = PoseHistory.of(self.board, posterior.camera, calibration, unreached)
            limits = history.restrict(EASY_LIMITS if skipped else PoseLimits())
            last = None
            if calibration is not None:
                r, t = rotation.matrix(calibration.poses[-1, :3]), calibration.poses[-1, 3:]
                last = Placement.of(self.board, posterior.camera, r, t)
            ahead = 2 if 0 < len(views) < MAX_PAIRED_VIEWS else 1
            return self.choose(posterior, len(views), limits, ahead, tuple(skipped), history, last)

    def choose(
        self,
        posterior: IntrinsicsPosterior,
        index: int,
        limits: PoseLimits,
        ahead: int = 1,
        skipped: tuple[TargetPose, ...] = (),
        history: PoseHistory | None = None,
        last: Placement | None = None,
    ) -> TargetPose:
        """Target by the posterior, as the next of `ahead` views; `index` varies the search."""
        # A part of a board without markers does not say which part it is.
        min_visible = min(1.0, MIN_CORNERS / self.board.corner_count) if self.board.has_markers else 1.0
        low, high = limits.width
        if min_visible == 1:
            high = min(high, max(low, self._whole_width()))
        min_width = posterior.rays.focal / (MAX_DISTANCE_LENGTHS * max(self.img_size))
        limits = replace(
            limits,
            min_visible=max(limits.min_visible, min_visible),
            border=WHOLE_BORDER if min_visible == 1 else limits.border,
            width=(min(max(low, min_width), max(low, 0.6 * high)), high),
        )
        found = Search(self.board, posterior, limits, skipped, history).best(index, ahead)
        if found is None:
            before_views = IntrinsicsPosterior.of(self.model.name, self.img_size, None, self.seed)
            return self.first_pose(before_views, posterior)
        unit, score = found
        ties = int(np.count_nonzero(score <= TIE_RATIO * score.min()))  # none where rounding is all there is
        unit = unit[np.argsort(score)][: max(ties, 1)]
        poses = candidates.poses_from_unit_cube(unit, self.board, posterior.rays, limits)
        pick = 0 if last is None else int(np.argmin(self._movement(poses, last)))
        r, t = poses.r[pick], poses.t[pick]
        s = self._information(posterior, r, t)
        purpose = self._purpose(posterior, s)
        return TargetPose.seen(self.board, posterior.camera, r, t, purpose, posterior.gain(s), last)

    def predict_posterior(self, posterior: IntrinsicsPosterior, target: TargetPose) -> IntrinsicsPosterior:
        """Posterior after a view of the target."""
        with np.errstate(all="ignore"):
            s = self._information(posterior, target.r, target.tvec)
        return replace(posterior, information=posterior.information + s / posterior.noise**2)

    def _information(self, posterior: IntrinsicsPosterior, r: Array, t: Array) -> Array:
        """Fisher information (p, p) of a view at rotation (3, 3) and translation (3,), at noise of 1 px."""
        s, _ = fisher_information(posterior, Poses(r[None], t[None]), self._corners, NO_LIMITS)
        return np.asarray(s[0])

    def first_pose(
        self, posterior: IntrinsicsPosterior, current: IntrinsicsPosterior | None = None
    ) -> TargetPose:
        """First target, an easy one; its gain is that over `current`, by default over the posterior."""
        length = 0.72 * self._whole_width()
        limits = PoseLimits(width=(length, length), max_tilt_deg=44.0, max_roll_deg=0.0)
        unit = np.array([[0.5, 0.5, 0.5, 1.0, 0.82, 0.5]])
        poses = candidates.poses_from_unit_cube(unit, self.board, posterior.rays, limits)
        r, t = poses.r[0], poses.t[0]
        gain = (current or posterior).gain(self._information(posterior, r, t))
        return TargetPose.seen(self.board, posterior.camera, r, t, "a first look", gain)

    def _whole_width(self) -> float:
        """Largest apparent length of the board's longer side / the image's, with all of it visible."""
        image, board = sorted(self.img_size), sorted(self.board.size)
        return min(1.0, image[0] * board[1] / (image[1] * board[0]))

    def _movement(self, poses: Poses, last: Placement) -> Array:
        """Movement (c,) of the hand: logarithm of the distances' ratio, and the change of the normal."""
        center = poses.r @ self.board.outline.mean(axis=0) + poses.t
        distance = np.abs(np.log(np.linalg.norm(center, axis=1) / last.distance))
        return np.asarray(distance + np.linalg.norm(poses.r[:, :, 2] - last.normal, axis=1))

    def _purpose(self, posterior: IntrinsicsPosterior, s: Array) -> str:
        before = symmetric_inverse(posterior.information)
        after = symmetric_inverse(posterior.information + s / posterior.noise**2)
        ratio = np.diagonal(after) / np.diagonal(before)
        groups = {
            "the focal length": ratio[:2].min(),
            "the centre of the image": ratio[2:4].min(),
            "the distortion": ratio[4:].min(),
        }
        return f"to measure {min(groups, key=lambda name: float(groups[name]))}"


PLAN_LENGTH = 10
PLAN_LIMITS = PoseLimits(width=(0.35, 1.1), max_tilt_deg=50.0, max_roll_deg=45.0, min_visible=0.75)
"""Narrower than usual: no server checks that the board was found."""


def fixed_plan(board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> tuple[TargetPose, ...]:
    """Poses chosen beforehand for the prior's camera; always the same for the same arguments.

    They serve a client that has lost its server, and are the baseline for the guidance that adapts. A user
    who follows the outline comes close enough whatever the true focal length is.
    """
    chooser = ProjectionUncertainty(board, img_size, model)
    posterior = IntrinsicsPosterior.of(model, img_size, None)
    with np.errstate(all="ignore"):
        chosen = [chooser.first_pose(posterior)]
        for index in range(1, PLAN_LENGTH):
            posterior = chooser.predict_posterior(posterior, chosen[-1])
            last = Placement.of(board, posterior.camera, chosen[-1].r, chosen[-1].tvec)
            chosen.append(chooser.choose(posterior, index, PLAN_LIMITS, last=last))
    return tuple(chosen)
