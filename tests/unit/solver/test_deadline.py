"""Deadline of a computation."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from calibsolver import Board, Calibration, DeadlineError, View, deadline, fit
from calibsolver.capture import Capture, consistency
from calibsolver.capture.consistency import Consistency
from calibsolver.capture.decision import ViewDecision
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportSource, write
from calibsolver.quality.model_selection import suggest_model
from tests.helpers.solver import populations, synthetic

BOARD = Board()
CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size


class Steps:
    """Seconds left that fall by one with every question, in place of a clock."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.asked = 0

    def __call__(self) -> float:
        self.asked += 1
        return self.seconds - self.asked


VIEWS = populations.views(CAMERA, np.random.default_rng(0), count=4)
COMPUTATIONS: dict[str, Callable[[], object]] = {
    "fit": lambda: fit(VIEWS, SIZE),
    "fit by least squares": lambda: fit(VIEWS, SIZE, robust=False),
    "resection": lambda: reprojection_score(CAMERA, VIEWS),
    "model selection": lambda: suggest_model(VIEWS, SIZE),
    "estimate": lambda: Capture(BOARD, SIZE).estimate(VIEWS),
    "export": lambda: write(ExportSource(CAMERA, tuple(VIEWS)), "gyroflow"),
}


@pytest.mark.parametrize("name", COMPUTATIONS)
def test_computation_that_runs_out_of_time_ends_within_two_questions(name: str) -> None:
    left = Steps(2)
    with deadline.limit(left), pytest.raises(DeadlineError):
        COMPUTATIONS[name]()
    assert left.asked <= 2 + 2


def test_deadline_changes_no_result() -> None:
    free = fit(VIEWS, SIZE).camera
    with deadline.limit(lambda: 1.0):
        assert np.array_equal(fit(VIEWS, SIZE).camera.intrinsics, free.intrinsics)


def test_outer_limit_holds_within_an_inner_one() -> None:
    with deadline.limit(lambda: 0.0), deadline.limit(lambda: 9.0), pytest.raises(DeadlineError):
        deadline.check()
    deadline.check()  # and none is left behind


def search_for_ever(*_: object) -> str:
    while True:
        deadline.check()


def test_share_that_is_used_up_gives_the_alternative() -> None:
    left = Steps(100)
    with deadline.limit(left):
        assert deadline.compute_within(10, search_for_ever, "otherwise") == "otherwise"
    assert 10 <= left.asked <= 14


def test_share_larger_than_the_time_left_raises_deadline_error() -> None:
    with deadline.limit(Steps(5)), pytest.raises(DeadlineError):
        deadline.compute_within(10, search_for_ever, "otherwise")


def contradict(board: Board, views: list[View]) -> Callable[[], ViewDecision]:
    rng = np.random.default_rng(1)
    capture = Capture(board, SIZE, target_error=1e-3)
    target = capture.next_target(views, capture.estimate(views))
    pose = synthetic.User().hold(board, target, rng)
    lie = synthetic.detect(board, synthetic.rectilinear_cameras()[0], *pose, rng)
    return lambda: Capture(board, SIZE, target_error=1e-3).judge(views, target, lie)


def test_contradicting_view_is_refused_where_the_search_runs_out_of_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judge = contradict(BOARD, VIEWS)
    assert not judge().accepted
    monkeypatch.setattr(Consistency, "find_conflicting_view", search_for_ever)
    left = Steps(1e6)  # far more than its share of a second
    with deadline.limit(left):
        decision = judge()
    assert (decision.accepted, decision.reason) == (False, "outlier")
    assert left.asked < 1e5


def test_contradicting_view_of_a_dense_board_is_fitted_to_few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    board = Board(squares=(30, 25), dictionary="DICT_APRILTAG_36h10")
    views = populations.views(CAMERA, np.random.default_rng(0), board=board)
    judge = contradict(board, views)
    counted: list[int] = []

    def counting(views: list[View], *args: Any, **options: Any) -> Calibration:
        counted.append(sum(map(len, views)))
        return fit(views, *args, **options)

    monkeypatch.setattr(consistency, "fit", counting)
    assert judge().reason == "outlier"
    whole = sum(map(len, views))
    assert sum(n > whole / 2 for n in counted) <= 1  # the fit that the view is compared with
    assert sum(n for n in counted if n <= whole / 2) < 1.5 * whole


def test_capture_ends_where_the_whole_board_has_no_room() -> None:
    """With nine views of 2,352 corners, 20,000 points leave no room for another."""
    board = Board(squares=(49, 50), dictionary="DICT_APRILTAG_36h10")
    rng = np.random.default_rng(0)
    views = []
    for turn in np.linspace(-0.5, 0.5, 9):
        rvec = np.array([turn, 0.4 * np.cos(5 * turn), 0.1 * turn])
        views.append(synthetic.detect(board, CAMERA, rvec, np.array([-25.0, -25.0, 75.0]), rng))
    capture = Capture(board, SIZE, target_error=1e-3)
    assert not capture.estimate(views[:5]).converged
    ended = capture.estimate(views)
    assert ended.converged
    assert [advice.code for advice in ended.advice] == ["limit_reached"]
