"""Hostile views: an honest user can still finish the session after any sequence of them."""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest

from calibsolver import Board, Camera, View, rotation
from calibsolver.capture import MAX_VIEWS, Capture, Exclusion, History
from calibsolver.capture.consistency import Consistency
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic

BOARD = Board()
CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size
HIDDEN = pytest.mark.xfail(
    strict=True, reason="Eight wrong views hide one another. The capture ends 7 px off, and states 14 px."
)
Hostile = Callable[["Session", View], View]


class Session(synthetic.Sitting):
    """A capture, its open target, and the reasons of refusals."""

    def __init__(self, seed: int = 0, **rules: Any) -> None:
        super().__init__(Capture(BOARD, SIZE, **rules))
        self.rng = np.random.default_rng(seed)
        self.reasons: list[str] = []
        self.target = self.rules.next_target([], self.estimate)

    def honest(self, camera: Camera = CAMERA) -> View:
        """The board held where the picture shows it, about, before `camera`."""
        asked = synthetic.match_picture(BOARD, self.rules.camera(self.estimate), camera, self.target)
        return synthetic.detect(BOARD, camera, *synthetic.User().hold(BOARD, asked, self.rng), self.rng)

    def submit(self, view: View) -> bool:
        decision = self.offer(self.target, view)
        if decision.estimate is None:
            assert decision.reason is not None
            assert decision.hint is not None
            self.reasons.append(decision.reason)
            return False
        if not self.estimate.converged:
            self.target = self.rules.next_target(self.views, self.estimate)
        return True

    def show(self, view: Callable[[], View], max_attempts: int = 40) -> None:
        """Submit views until the capture ends."""
        for _ in range(max_attempts):
            if self.estimate.converged:
                break
            self.submit(view())

    def finish(self, max_attempts: int = 14) -> float:
        """Go on honestly until it converges: mean projection error, px."""
        self.show(self.honest, max_attempts)
        assert self.estimate.converged, (self.reasons, self.estimate)
        found = self.rules.camera(self.estimate)
        return float(synthetic.projection_error(CAMERA, found).mean())


def other_camera(focal: float = 700.0, squash: float = 1.0) -> Camera:
    matrix = np.array([[focal, 0, 640], [0, focal * squash, 360], [0, 0, 1.0]])
    return Camera("rectilinear", matrix, np.array([-0.05, 0, 0, 0, 0]), SIZE)


def shift_picture(session: Session, view: View) -> View:
    """A stabiliser shifts the picture, elsewhere each time; a turn of the board explains it up to a point."""
    shift = session.rng.uniform(-150, 150, 2)
    q = view.image_points + shift
    inside = ((q >= 0) & (q <= (SIZE[0] - 1, SIZE[1] - 1))).all(axis=1)
    return View(view.object_points[inside], q[inside])


def swap_rows(_: Session, view: View) -> View:
    p = view.object_points.copy()
    row = p[:, 1].copy()
    p[row == 2, 1], p[row == 4, 1] = 4, 2
    return View(p, view.image_points)


def rename_corners(_: Session, view: View) -> View:
    """Ids of another board."""
    return View(np.random.default_rng(5).permutation(view.object_points), view.image_points)


HOSTILE: tuple[Hostile, ...] = (
    lambda s, v: View(v.object_points, s.rng.uniform(0, 719, (len(v), 2))),
    lambda _, v: View(v.object_points, (SIZE[0] - 1, 0) + v.image_points * (-1, 1)),
    swap_rows,
    rename_corners,
)


@pytest.mark.parametrize("seed", [3, *thorough(0, 1, 2)])
def test_session_converges_after_views_that_are_no_boards(seed: int) -> None:
    session = Session(seed=seed)
    for sent in (*HOSTILE, *HOSTILE):
        assert not session.submit(sent(session, session.honest()))
    assert set(session.reasons) <= {"outlier", "mirrored", "degenerate"}
    view = session.honest()
    assert session.submit(view)
    del session.reasons[:]
    for _ in range(9):
        copy = View(view.object_points, view.image_points + 0.02 * session.rng.normal(size=(len(view), 2)))
        assert not session.submit(copy)
    assert session.reasons == ["duplicate"] * 9
    assert not session.estimate.converged
    assert session.finish() < 0.6


@pytest.mark.parametrize(
    ("good_first", "seed", "sent"),
    [
        (2, 7, 3),
        *thorough((2, 7, 10), (0, 3, 10), (0, 4, 10), (2, 4, 10)),
        pytest.param(0, 5, 10, marks=[pytest.mark.thorough, HIDDEN]),
    ],
)
def test_session_converges_after_views_that_can_be_explained(good_first: int, seed: int, sent: int) -> None:
    session = Session(seed=seed)
    for _ in range(good_first):
        assert session.submit(session.honest())
    session.show(lambda: shift_picture(session, session.honest()), sent)
    not_counted = len(session.reasons) + len(session.estimate.excluded)
    assert not session.estimate.converged
    assert session.finish() < 0.6
    assert not_counted >= 3


@pytest.mark.parametrize(
    ("focal", "squash"), [(2200.0, 1.0), *thorough((450.0, 0.75), (450.0, 1.0), (2200.0, 0.75))]
)
def test_wrong_first_view_is_excluded_by_later_views(focal: float, squash: float) -> None:
    """It is another camera's and fits by itself: only the honest views contradict it."""
    session = Session(seed=2)
    taken = session.submit(session.honest(other_camera(focal, squash)))
    assert taken or squash < 1  # no camera's pixels are so far from square
    assert session.finish() < 0.6
    if taken:
        assert 0 in session.estimate.excluded
        assert session.estimate.excluded[0].detail
        assert session.estimate.view_errors[0] is not None
        undone = session.rules.reconcile(session.views[:1], {0: session.estimate.excluded[0]})
        assert undone.excluded == {}
        assert undone.calibration is not None
    assert session.rules.reconcile([], {}).calibration is None


@pytest.mark.parametrize(
    ("seed", "focal"),
    [(1, 2200.0), *thorough(*product((0, 4), (450.0, 600.0, 2200.0)))],
)
def test_exactly_the_wrong_views_are_refused_or_excluded(seed: int, focal: float) -> None:
    """Of six views the second and the fourth are another camera's; 1280 x 720, true focal length 942 px."""
    session = Session(seed=seed)
    wrong, refused = set[int](), 0
    for i in range(6):
        if i not in (1, 3):
            session.submit(session.honest())
        elif session.submit(session.honest(other_camera(focal))):
            wrong.add(len(session.views) - 1)
        else:
            refused += 1
    assert session.finish() < 0.6
    assert set(session.estimate.excluded) == wrong
    assert refused + len(wrong) == 2


def test_three_views_of_a_changed_camera_are_outvoted() -> None:
    """Three views of another camera come first; four that agree outvote them."""
    session = Session(seed=9)
    for _ in range(3):
        session.submit(session.honest(other_camera(620.0)))
    wrong = set(range(len(session.views)))
    assert session.finish(max_attempts=16) < 0.6
    assert len(session.views) - len(session.estimate.excluded) >= 4
    assert set(session.estimate.excluded) == wrong


def test_undo_and_exclusion_refit_the_remaining_views() -> None:
    session = Session(seed=6)
    session.finish()
    for i in range(len(session.views)):
        others = [*session.views[:i], *session.views[i + 1 :]]
        left = session.rules.reconcile(others, {})
        assert len(left.view_errors) == len(others)
        assert left.excluded == {}
        found = session.rules.camera(left)
        assert synthetic.projection_error(CAMERA, found).mean() < 1.5
    excluded = {1: Exclusion("outlier", "It is.")}
    estimate = session.rules.estimate(session.views, excluded)
    assert estimate.excluded == excluded
    assert (estimate.view_errors[1] or np.inf) < 2


@pytest.mark.parametrize("before", [9, *thorough(0)])
def test_capture_ends_where_the_error_falls_no_more(before: int) -> None:
    session = Session(seed=7, target_error=0.001)
    if before:
        session.views = populations.views(CAMERA, np.random.default_rng(0), count=before)
        session.estimate = session.rules.estimate(session.views)
        assert session.estimate.uncertainty is not None
        session.history = History((session.estimate.uncertainty.rms,) * before, (True,) * before)
        session.target = session.rules.next_target(session.views, session.estimate)
    session.show(session.honest)
    assert session.estimate.end == "plateau"
    assert 10 <= len(session.views) < MAX_VIEWS
    assert session.estimate.progress == 1
    assert session.estimate.advice == ()


@pytest.mark.parametrize("before", [13, *thorough(0)])
def test_capture_off_the_target_ends_at_max_views_with_advice(before: int) -> None:
    """A user who ignores the outline is refused duplicates only, and the capture ends."""
    session = Session(seed=7, target_error=0.001)

    def anywhere() -> View:
        rvec = np.radians(25) * session.rng.normal(size=3)
        tvec = session.rng.uniform((-7, -4.5, 11), (-2, -1.5, 16))
        return synthetic.detect(BOARD, CAMERA, rvec, tvec, session.rng)

    session.views = [anywhere() for _ in range(before)]
    session.estimate = session.rules.estimate(session.views)
    session.show(anywhere)
    assert len(session.views) == MAX_VIEWS
    assert session.estimate.end == "limit"
    assert set(session.reasons) <= {"duplicate"}
    assert session.estimate.progress == 1
    assert [advice.code for advice in session.estimate.advice] == ["limit_reached"]
    assert session.estimate.uncertainty is not None
    assert 0.001 < session.estimate.uncertainty.rms < 5


@pytest.mark.parametrize("seed", [0, *thorough(1, 2)])
def test_rational_model_converges_on_noiseless_corners(seed: int) -> None:
    """A simulated camera: nothing but rounding and the prior determines what is not seen."""
    session = Session(seed=seed, model="rational")

    def noiseless() -> View:
        q = CAMERA.project(BOARD.points @ session.target.r.T + session.target.tvec)
        inside = ((q >= 0) & (q <= np.array(SIZE) - 1)).all(axis=1)
        return View(BOARD.points[inside], q[inside])

    session.show(noiseless, 6)
    assert session.finish() < 0.01


@pytest.mark.parametrize("width", [0.1, *thorough(0.6)])
def test_noiseless_first_view_does_not_make_others_outliers(width: float) -> None:
    session, rvec = Session(seed=3), np.array([0.3, 0.4, 0.0])
    middle = np.array([0, 0, 9 * CAMERA.matrix[0, 0] / (width * SIZE[0])])
    tvec = middle - rotation.matrix(rvec) @ BOARD.outline.mean(axis=0)
    assert session.submit(synthetic.detect(BOARD, CAMERA, rvec, tvec, session.rng, noise=0))
    session.finish(6)


# Rotation vectors, and places of the board's middle, in squares
POSES = [
    ((0.5, 0.0, 0.0), (0, 0, 11)),
    ((-0.5, 0.1, 0.1), (3, 1, 12)),
    ((0.0, 0.6, 0.0), (-3, 1, 12)),
    ((0.1, -0.6, 0.2), (2, -1, 13)),
    ((0.4, 0.4, 1.5), (-2, -1, 12)),
    ((-0.3, -0.4, 0.0), (0, 1, 14)),
]


def view_of(camera: Camera, index: int) -> View:
    """The board in the pose of that number, before a camera."""
    turn, middle = POSES[index]
    rvec = np.array(turn)
    tvec = np.array(middle) - rotation.matrix(rvec) @ (4.5, 3, 0)
    return synthetic.detect(BOARD, camera, rvec, tvec, np.random.default_rng(index))


@pytest.mark.parametrize("place", [0, 1])
def test_view_of_another_camera_is_an_outlier_and_conflicts_with_the_next_view(place: int) -> None:
    views = [view_of(CAMERA, index) for index in range(len(POSES))]
    consistency = Consistency(SIZE, "rectilinear")
    assert consistency.find_outlier_view(views) is None
    assert consistency.find_conflicting_view(views[:4], views[5]) is None
    views[place] = view_of(other_camera(), place)
    assert consistency.find_outlier_view(views) == place
    assert consistency.find_conflicting_view(views[:4], views[5]) == place
