"""Looks for the poses after which the projection error is least, among those a person can hold."""

from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array, IntArray, Mask
from ..board import Board
from ..fitting import normal_equations
from ..fitting.normal_equations import Poses
from . import candidates
from .belief import Belief
from .candidates import Lattice, Range
from .experience import Experience
from .target import TargetPose

CANDIDATES = 128
BEST, AROUND = 4, 16
"""How many of the candidates are refined, and how many are tried around each."""
WIDE = (0.3, 0.2, 0.14, 0.09, 0.05)
NARROW = (0.2, 0.12, 0.06)
"""How far around, in units of a candidate's range: in a search, and where many have been tried before."""


@dataclass(frozen=True, eq=False)
class Tried:
    """Candidates looked at: points (c, 6) of the unit cube, and what each tells, whitened (c, p, p)."""

    unit: Array
    tells: Array

    def and_(self, other: "Tried") -> "Tried":
        """Return both."""
        return Tried(np.concatenate([self.unit, other.unit]), np.concatenate([self.tells, other.tells]))

    def of(self, index: IntArray) -> "Tried":
        """Return some."""
        return Tried(self.unit[index], self.tells[index])


def whitening(information: Array) -> Array:
    """Return M (p, p) with M A M' = 1 for what is known, A (p, p).

    Corners with hardly any noise leave some directions known so much better than others that rounding makes
    A indefinite: of the worst it is then taken to say next to nothing.
    """
    scale = 1 / np.sqrt(np.maximum(np.diagonal(information), 1e-300))
    unit = information * scale[:, None] * scale + 1e-13 * np.eye(len(scale))
    try:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(unit)) * scale)
    except np.linalg.LinAlgError:
        values, axes = np.linalg.eigh(unit)
        return np.asarray(axes.T / np.sqrt(np.maximum(values, 1e-9))[:, None] * scale)


class Search:
    """The cross-entropy method: spread widely, then ever closer around the best so far.

    Information is whitened by what is known before, so that nothing is badly scaled: with A = L L' known,
    trace((A + S)^-1 W) = trace((1 + L^-1 S L^-T)^-1 L^-1 W L^-T).

    Parameters
    ----------
    board
        What is held.
    belief
        What is known of the camera.
    limits
        What may be asked for.
    skipped
        Targets that candidates must not resemble.
    experience
        What noise to expect of which pose; None where nothing is known.
    """

    def __init__(
        self,
        board: Board,
        belief: Belief,
        limits: Range,
        skipped: tuple[TargetPose, ...] = (),
        experience: Experience | None = None,
    ) -> None:
        self.board = board
        self.belief = belief
        self.limits = limits
        self.skipped = skipped
        self.experience = experience
        self.lattice = Lattice.of(board, 5)
        self._whiten = whitening(belief.information)
        self._weight = self._whiten @ belief.weight @ self._whiten.T
        self._around = candidates.sequence(AROUND * BEST, 1) - 0.5

    def first(self, index: int) -> Tried:
        """Try CANDIDATES poses from everywhere; `index` varies which."""
        return self.tried(candidates.sequence(CANDIDATES, index + 7 * len(self.skipped)))

    def tried(self, unit: Array) -> Tried:
        """Look at candidates (c, 6); those that may not be asked for are left out."""
        belief = self.belief
        poses = candidates.poses(unit, self.board, belief.sight, self.limits)
        s, good = information(belief, poses, self.lattice, self.limits)
        good &= candidates.in_front(poses, self.board, belief.sight)
        for target in self.skipped:
            good &= ~alike(poses, target, self.board)
        use = np.flatnonzero(good)
        noise = np.full(use.size, belief.noise)
        if self.experience is not None:
            noise *= self.experience.expected_noise(*candidates.shape(unit[use], self.limits))
        return Tried(unit[use], self._whiten @ (s[use] / noise[:, None, None] ** 2) @ self._whiten.T)

    def score(self, tells: Array, also: Array | None = None) -> Array:
        """Mean square projection error (c,) px^2 after candidates that tell (c, p, p), and `also` (p, p)."""
        known = np.eye(len(self._weight)) if also is None else np.eye(len(self._weight)) + also
        error: Array = np.einsum("cij,ij->c", np.linalg.inv(known + tells), self._weight)
        return error

    def refine(
        self, tried: Tried, radii: tuple[float, ...], also: Array | None = None
    ) -> tuple[Tried, Tried, Array]:
        """Search around the best of those `tried`, after `also` (p, p): all, the last round, its scores."""
        score = self.score(tried.tells, also)
        everything, last = tried, tried
        for radius in radii:
            if not last.unit.size:
                break
            best = np.argsort(score)[:BEST]
            near = np.repeat(last.unit[best], AROUND, axis=0)
            near = near + 2 * radius * self._around[: len(near)]
            near[:, 4] %= 1.0
            new = self.tried(np.clip(near, 0.0, 1.0))
            everything, last = everything.and_(new), last.of(best).and_(new)
            score = np.concatenate([score[best], self.score(new.tells, also)])
        return everything, last, score

    def best(self, index: int, ahead: int) -> tuple[Array, Array] | None:
        """Return the best candidates (c, 6) for the next of `ahead` views, 1 or 2, and their scores (c,).

        The best single pose need not be one of the best two: the second is chosen to go with the first, and
        then the first again to go with the second. The one that helps more by itself is asked for first.
        """
        everything, last, score = self.refine(self.first(index), WIDE)
        if not last.unit.size:
            return None
        if ahead < 2:
            return last.unit, score
        one = last.tells[int(np.argmin(score))]
        everything, last, score = self.refine(everything, NARROW, one)
        other, with_one = last.of(np.argsort(score)[:8]), float(score.min())
        pair = other.tells[0]
        _, last, score = self.refine(everything, NARROW, pair)
        again = last.of(np.argsort(score)[:8])
        if score.min() < with_one:
            one = again.tells[0]
        alone = self.score(np.stack([one, pair]))
        if alone[1] < alone[0]:
            return other.unit, self.score(other.tells, one)
        return again.unit, self.score(again.tells, pair)


def information(belief: Belief, poses: Poses, lattice: Lattice, limits: Range) -> tuple[Array, Mask]:
    """Information (c, p, p) at unit noise of poses (c), and whether each may be asked for (0 where not)."""
    p = poses.r @ lattice.points + poses.t[:, :, None]
    q = belief.model.project(belief.k, p.transpose(1, 0, 2)).transpose(1, 0, 2)
    seen, good = candidates.visible(
        p, q, poses.r[:, :, 2], lattice, belief.model, belief.k, belief.img_size, limits
    )
    use = np.flatnonzero(good)
    s = np.zeros((len(good), belief.model.size, belief.model.size))
    if use.size:
        _, j = normal_equations.projection_jacobian(
            belief.model, belief.k, Poses(poses.r[use], poses.t[use]), lattice.points
        )
        seen = seen[use]
        j = np.where(seen[:, None, None, :], j, 0.0)
        s[use] = normal_equations.fisher_information(j, seen.astype(np.float64) * lattice.share)
    return s, good


def alike(poses: Poses, target: TargetPose, board: Board) -> Mask:
    """Whether poses (c) are much like a target: normals within 20 degrees, centres within 1.5 squares."""
    r = rotation.matrix(target.rvec)
    center = board.outline.mean(axis=0)
    place = np.linalg.norm(poses.r @ center + poses.t - (r @ center + target.tvec), axis=1)
    angle = poses.r[:, :, 2] @ r[:, 2]
    same: Mask = (angle > np.cos(np.radians(20))) & (place < 1.5)
    return same
