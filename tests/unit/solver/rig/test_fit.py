"""Rigs fitted together: real pairs against OpenCV, synthetic rigs against the truth, what is refused."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from calibsolver import Board, CalibrationError, Camera, View, rig
from calibsolver.arrays import Array
from calibsolver.fitting.levenberg_marquardt import State
from calibsolver.fitting.normal_equations import Poses
from calibsolver.rig import transfer
from calibsolver.rig.problem import MIN_KEPT_POINTS, RigProblem, thin, thin_view
from calibsolver.rig.start import RigidMotion
from tests.bench import rigs as bench
from tests.helpers.marks import thorough
from tests.helpers.solver import hands, rigs, synthetic

BOARD = Board((9, 6))
DENSE = Board((50, 49), dictionary="DICT_APRILTAG_36h10")
SIZE = rigs.REAL_SIZE
PAIR = [(SIZE, "rectilinear")] * 2
FLAT, WIDE = synthetic.rectilinear_cameras(12), synthetic.fisheye_cameras(12)


def opencv(moments: list[dict[int, View]]) -> tuple[float, Any, Any]:
    """Rms px, rotation (3, 3) and translation (3,) of cv2.stereoCalibrate, everything free."""
    points = [moment[0].object_points.astype(np.float32) for moment in moments]
    pixels = [[moment[i].image_points.astype(np.float32) for moment in moments] for i in (0, 1)]
    singles = [cv2.calibrateCamera(points, seen, SIZE, None, None)[1:3] for seen in pixels]
    found = cv2.stereoCalibrate(
        points, *pixels, *singles[0], *singles[1], SIZE, flags=0, criteria=(3, 100, 1e-9)
    )
    return found[0], found[5], found[6].ravel()


def fitted(
    truth: rigs.Rig, moments: list[dict[int, View]], **options: Any
) -> tuple[rig.RigCalibration, float]:
    """Fit of all of a rig's cameras, and its error of transfer at working distance, px."""
    found = rig.fit(moments, [(camera.img_size, camera.model) for camera in truth.cameras], **options)
    distances = found.working_distances.tolist()
    return found, rigs.transfer_error(truth, rigs.Rig(found.cameras, found.motions), distances)


def angle_deg(one: RigidMotion, other: Array) -> float:
    return float(np.degrees(np.linalg.norm(RigidMotion(one.r @ other.T, one.t).vector()[:3])))


def test_real_pair_agrees_with_opencv_once_the_reversed_view_is_turned_back() -> None:
    moments = rigs.real_pairs()
    assert len(moments) == 13
    found = rig.fit(moments, PAIR, board_shape=False)
    assert [m for m, _ in found.turned] == [8], "pair 09"
    assert found.set_aside == {}
    assert found.rms <= 0.271
    pairs = rigs.corrected_pairs()
    rms, r, t = opencv(pairs)
    assert found.rms == pytest.approx(rms, abs=2e-4)
    assert np.linalg.norm(found.poses[1, 3:]) == pytest.approx(np.linalg.norm(t), abs=0.005)
    assert angle_deg(found.motions[1], r) < 0.05
    as_opencv = rig.fit(pairs, PAIR, robust=False)
    assert as_opencv.rms == pytest.approx(rms, abs=5e-6)


def test_real_pair_predicts_moments_it_never_saw() -> None:
    """Pair 09 is numbered from both ends, in the part that is left out as well as in training."""
    moments = rigs.real_pairs()
    found = rig.fit(moments, PAIR)
    left_out = rig.held_out_rms(moments, found)
    assert left_out is not None
    assert found.rms < left_out < 1.1 * found.rms
    drawn = rig.fit(moments, PAIR, board_shape=False)
    assert left_out < 0.98 * (rig.held_out_rms(moments, drawn) or 0), "the board is not as drawn"
    assert found.uncertainty.rms < drawn.uncertainty.rms
    assert rig.held_out_rms(moments[:1], found) is None, "nothing would link the cameras"
    held = rig.fit(moments, found.cameras)
    for mine, given in zip(held.cameras, found.cameras, strict=True):
        assert mine.intrinsics.tolist() == given.intrinsics.tolist()
    assert not held.covariance[:18].any()
    assert (np.diagonal(held.covariance)[18:] > 0).all()
    assert found.rms < (rig.held_out_rms(moments, held) or np.inf) < left_out


def test_fit_predicts_the_error_of_stereo_and_mixed_rigs() -> None:
    """200 of each are in the benchmark."""
    errors, predicted = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        cameras = [FLAT[seed], WIDE[seed]] if seed % 2 else [WIDE[seed], WIDE[5 - seed]]
        truth = rigs.side_by_side(cameras, rng.uniform(1, 3))
        found, error = fitted(truth, rigs.moments(truth, BOARD, 8, 0.2, rng))
        assert found.set_aside == {}
        assert found.rms == pytest.approx(0.2 * np.sqrt(2), rel=0.1)
        errors.append(error)
        predicted.append(found.uncertainty.rms)
    assert 0.6 < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(predicted))) < 1.5


@pytest.mark.parametrize("seed", [2, *thorough(9)])
def test_fit_closes_a_ring_whose_neighbours_alone_share_views(seed: int) -> None:
    """A camera with three views has a start far from what it sees, and no view is wrong."""
    rng = np.random.default_rng(seed)
    cameras = [(WIDE if i % 2 else FLAT)[int(rng.integers(12))] for i in range(8)]
    truth = rigs.ring(cameras, 2.0)
    moments = rigs.moments(truth, BOARD, 24, 0.2, rng)
    assert all(not {i, (i + 4) % 8} <= set(moment) for moment in moments for i in range(8))
    found, error = fitted(truth, moments)
    assert found.set_aside == {}
    assert found.rms == pytest.approx(0.2 * np.sqrt(2), rel=0.05)
    assert error < 0.25


def with_lies(truth: rigs.Rig, good: int, bad: int, rng: np.random.Generator) -> list[dict[int, View]]:
    """Moments of which `bad` ones, the last, show another pose of the board to camera 1."""
    moments = rigs.moments(truth, BOARD, good, 0.2, rng)
    while len(moments) < good + bad:
        one, other = (rigs.moments(truth, BOARD, 1, 0.2, rng)[0] for _ in range(2))
        if 0 in one and 1 in other:
            moments.append({0: one[0], 1: other[1]})
    return moments


@pytest.mark.parametrize(
    ("seed", "bad"), [(1, 3), *thorough((0, 2), (0, 3), (1, 2), (2, 2), (2, 3), (3, 2), (3, 3))]
)
def test_moments_that_contradict_the_majority_are_set_aside(seed: int, bad: int) -> None:
    rng = np.random.default_rng(seed)
    truth = rigs.side_by_side([FLAT[int(rng.integers(12))], FLAT[int(rng.integers(12))]], 2.0)
    found, error = fitted(truth, with_lies(truth, 5, bad, rng))
    assert {m for m, _ in found.set_aside} == set(range(5, 5 + bad))
    assert set(found.set_aside.values()) == {"contradicts"}
    assert error < 3 * found.uncertainty.rms
    assert found.rms < 0.35


@pytest.mark.parametrize("seed", [2, *thorough(4)])
def test_moments_none_of_which_agree_end_after_few_steps(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = 0
    linearize = RigProblem.at

    def counted(problem: RigProblem, k: Array, poses: Poses) -> State:
        nonlocal steps
        steps += 1
        return linearize(problem, k, poses)

    monkeypatch.setattr(RigProblem, "at", counted)
    truth = rigs.side_by_side([FLAT[seed], FLAT[seed + 3]], 2.0)
    moments = with_lies(truth, 1, 5, np.random.default_rng(seed))
    with pytest.raises(CalibrationError, match="contradict"):
        rig.fit(moments, [(c.img_size, "rational") for c in truth.cameras])
    assert steps < 1000


@pytest.mark.parametrize(("count", "seeds"), [(4, 2), *thorough((4, 5), (6, 5))])
def test_late_view_is_set_aside_to_which_the_fit_could_bend(count: int, seeds: int) -> None:
    """One picture is 200 ms old while a hand moves squares of 3 cm at 5 cm/s."""
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        truth = rigs.side_by_side(FLAT[:2], rng.uniform(1, 4))
        moments = rigs.moments(truth, BOARD, count, 0.2, rng)
        late = rigs.late_moment(truth, BOARD, 0.2 * 5 / 3, 0.2, rng)
        found, error = fitted(truth, [*moments, late])
        assert {m for m, _ in found.set_aside} == {count}
        assert error < 3 * found.uncertainty.rms


def test_another_boards_view_is_set_aside() -> None:
    truth = rigs.side_by_side(FLAT[:3], 1.0)
    moments = rigs.moments(truth, BOARD, 9, 0.2, np.random.default_rng(5), shared=3)
    moments[2][1] = moments[3][1]
    found, error = fitted(truth, moments)
    assert set(found.set_aside) == {(2, 1)}
    assert error < 0.6


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (lambda m, c: (m, c[:1]), "bad_rig", "2 to 8 cameras"),
        (lambda _, c: ([], c), "no_views", "moments"),
        (lambda m, c: ([*m, {7: m[0][0]}], c), "bad_rig", "camera 7"),
        (lambda m, c: ([{0: each[0]} for each in m], c), "unlinked", "camera 1"),
        (lambda m, c: ([{i % 2: each[i % 2]} for i, each in enumerate(m)], c), "unlinked", "camera 1"),
        (lambda m, c: (m, [c[0], (SIZE, "fishy")]), "unknown_model", "camera 1"),
    ],
)
def test_refusal_says_what_is_wrong(change: Any, code: str, words: str) -> None:
    moments, cameras = change(rigs.real_pairs(), PAIR)
    with pytest.raises(CalibrationError, match=words) as refused:
        rig.fit(moments, cameras)
    assert refused.value.code == code


def test_derivatives_are_those_of_the_residuals() -> None:
    """Central differences of residuals, of a rig of three models with one camera held."""
    cameras: list[Camera] = [*FLAT[:2], WIDE[0]]
    truth = rigs.side_by_side(cameras, 1.0)
    moments = rigs.moments(truth, BOARD, 3, 0.2, np.random.default_rng(0))
    problem = RigProblem.of(moments, cameras, [False, True, False], [1.0, 2.0, 3.0])
    k = problem.pack([c.intrinsics for c in cameras], np.array([m.vector() for m in truth.motions]))
    poses = Poses.of_vectors(np.tile([0.1, -0.2, 0.05, -4.0, -2.5, 12.0], (3, 1)))
    state = problem.at(k, poses)
    distances = np.array([10.0, 11.0, 12.0])
    transferred = transfer.jacobian(problem, k, distances)
    assert transferred.shape[2] == problem.size == 9 + 8 + 12

    def moved(i: int, h: float) -> Array:
        step, pose_step = np.zeros(problem.size), np.zeros((3, 6))
        if i < problem.size:
            step[i] = h
        else:
            pose_step[:, i - problem.size] = h
        return problem.residuals_of(k + step, poses.retract(pose_step), problem.obs)

    for i in range(problem.size + 6):
        h = 1e-6 * max(abs(k[i]), 1e-2) if i < problem.size else 1e-6
        change = (moved(i, h) - moved(i, -h)) / (2 * h)
        tolerance = 1e-5 * np.abs(change).max() + 1e-4 if i < problem.size else 1e-3
        assert state.rows[i] == pytest.approx(change, rel=1e-4, abs=tolerance)


def test_one_shape_of_the_board_is_estimated_of_all_cameras() -> None:
    """A bend of 0.5 % moves a rig by 1 to 4 px if the board is taken as drawn."""
    drawn, shaped = [], []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        truth = rigs.side_by_side(synthetic.rectilinear_cameras()[4:6], 2.0)
        board = Board()
        board.__dict__["points"] = hands.BENT.bend(board, rng)
        moments = [
            {i: replace(view, object_points=view.object_points * (1, 1, 0)) for i, view in moment.items()}
            for moment in rigs.moments(truth, board, 8, 0.2, rng)
        ]
        for errors, board_shape in ((drawn, False), (shaped, True)):
            found, error = fitted(truth, moments, board_shape=board_shape)
            errors.append(error)
            assert (found.board_shape is not None) == board_shape
        assert found.board_shape is not None
        assert 0.003 < found.board_shape.sag < 0.008
        flat = [{i: replace(view, flat=True) for i, view in moment.items()} for moment in moments]
        assert fitted(truth, flat)[0].board_shape is None
    assert np.median(shaped) < 0.3 < 1 < np.median(drawn)


def view_of(board: Board) -> View:
    """View of a whole board; the pixels do not matter."""
    return View(board.points, board.points[:, :2] * 10)


def test_one_dense_view_among_many_costs_no_more_than_its_share() -> None:
    sparse = View(DENSE.points[:100], DENSE.points[:100, :2] * 10)
    moments = [{i: view_of(DENSE) if m == 0 else sparse for i in range(8)} for m in range(100)]
    thinned = thin(moments, rig.MAX_ONLINE_POINTS)
    longest = max(len(view) for moment in thinned for view in moment.values())
    assert longest * 8 * 100 <= rig.MAX_ONLINE_POINTS
    assert longest >= MIN_KEPT_POINTS


@pytest.mark.parametrize("squares", [(50, 49), (24, 18), (14, 9), (18, 18), (9, 33)])
def test_points_kept_are_from_all_over_the_board(squares: tuple[int, int]) -> None:
    board = Board(squares, dictionary="DICT_APRILTAG_36h10")
    kept = thin_view(view_of(board), MIN_KEPT_POINTS)
    assert len(kept) == MIN_KEPT_POINTS
    assert thin_view(kept, MIN_KEPT_POINTS) is kept
    spread, whole = (
        np.linalg.svd(points[:, :2] - points[:, :2].mean(axis=0))[1]
        for points in (kept.object_points, board.points)
    )
    assert (spread / whole * np.sqrt(len(board.points) / MIN_KEPT_POINTS) > 0.75).all()


def test_thinned_rig_is_the_rig_within_its_stated_error() -> None:
    truth = rigs.side_by_side([FLAT[0], FLAT[5]], 2.0)
    board = Board((24, 18), dictionary="DICT_4X4_250")
    moments = rigs.moments(truth, board, 10, 0.2, np.random.default_rng(3))
    found, _ = fitted(truth, moments, max_points=1000)
    assert sum(len(view) for moment in moments for view in moment.values()) > 4000
    std = np.sqrt(np.diagonal(found.pose_covariance(1)))
    assert (np.abs(found.poses[1] - truth.motions[1].vector()) < 4 * std).all()
    assert found.uncertainty.rms < 1.0


@pytest.mark.parametrize("seeds", [1, *thorough(3)])
def test_guided_captures_of_two_webcams_end_after_a_few_moments(seeds: int) -> None:
    """At 6 to 60 cm; 200 captures are in the benchmark."""
    taken = []
    for seed in range(seeds):
        rng = np.random.default_rng(1000 + seed)
        taken.append(bench.capture(bench.webcams(rng), rng))
    moments, predicted, errors = np.array(taken).T
    assert np.median(moments) <= 8
    assert moments.max() <= bench.MAX_MOMENTS, "none is stuck"
    assert (predicted <= bench.GOAL).all()
    assert np.median(errors) < bench.GOAL


def test_the_first_target_is_whole_and_says_who_is_not_linked() -> None:
    cameras = [((1280, 720), "rectilinear"), ((640, 480), "fisheye"), ((640, 480), "rectilinear")]
    target = rig.next_moment(BOARD, cameras, [], None)
    assert target.pose is None
    assert target.unlinked == (1, 2)
    (view,) = target.views.values()
    assert len(view.ids) == BOARD.corner_count


def test_targets_of_known_lenses_are_seen_by_both_and_skipped_ones_do_not_return() -> None:
    """Intrinsics that are held leave poses that both cameras see as the only ones that tell anything."""
    truth = rigs.side_by_side(synthetic.rectilinear_cameras(2), 2.0)
    moments = rigs.moments(truth, BOARD, 3, 0.2, np.random.default_rng(2))
    found = rig.fit(moments, truth.cameras)
    target = rig.next_moment(BOARD, truth.cameras, moments, found)
    assert set(target.views) == {0, 1}
    assert min(len(view.ids) for view in target.views.values()) >= 0.3 * BOARD.corner_count
    assert target.pose is not None
    other = rig.next_moment(BOARD, truth.cameras, moments, found, [target.pose])
    assert other.pose is not None
    assert np.linalg.norm(other.pose - target.pose) > 0.3
