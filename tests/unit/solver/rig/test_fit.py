"""Rigs fitted together: real pairs against OpenCV, synthetic rigs against the truth, and what is refused."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from calibsolver import Board, CalibrationError, Camera, View, fit, rig
from calibsolver.arrays import Array
from calibsolver.fitting.normal_equations import Poses
from calibsolver.rig import transfer
from calibsolver.rig.problem import RigProblem
from calibsolver.rig.start import RigidMotion
from tests.helpers.marks import thorough
from tests.helpers.solver import hands, rigs, synthetic

BOARD = Board((9, 6))
SIZE = (640, 480)


def opencv(moments: list[dict[int, View]]) -> tuple[float, Any, Any]:
    """Rms px, rotation (3, 3) and translation (3,) of cv2.stereoCalibrate, everything free."""
    points = [moment[0].object_points.astype(np.float32) for moment in moments]
    pixels = [[moment[i].image_points.astype(np.float32) for moment in moments] for i in (0, 1)]
    singles = [cv2.calibrateCamera(points, seen, SIZE, None, None)[1:3] for seen in pixels]
    found = cv2.stereoCalibrate(
        points, *pixels, *singles[0], *singles[1], SIZE, flags=0, criteria=(3, 100, 1e-9)
    )
    return found[0], found[5], found[6].ravel()


class TestRealPair:
    def test_agrees_with_opencv_once_the_reversed_view_is_turned_back(self) -> None:
        moments = rigs.real_pairs()
        assert len(moments) == 13
        found = rig.fit(moments, [(SIZE, "rectilinear")] * 2, board_shape=False)
        assert [m for m, _ in found.turned] == [8], "pair 09"
        assert found.set_aside == {}
        assert found.rms <= 0.271
        mended = rigs.mended_pairs()
        rms, r, t = opencv(mended)
        assert found.rms == pytest.approx(rms, abs=2e-4)
        assert np.linalg.norm(found.poses[1, 3:]) == pytest.approx(np.linalg.norm(t), abs=0.005)
        turn = RigidMotion.of_vector(found.poses[1]).r @ r.T
        assert np.degrees(np.arccos((np.trace(turn) - 1) / 2)) < 0.05
        as_opencv = rig.fit(mended, [(SIZE, "rectilinear")] * 2, robust=False)
        assert as_opencv.rms == pytest.approx(rms, abs=5e-6)

    def test_intrinsics_that_are_held_stay_and_have_no_variance(self) -> None:
        moments = rigs.real_pairs()
        held = [fit([moment[i] for moment in moments], SIZE).camera for i in (0, 1)]
        found = rig.fit(moments, held)
        for i in (0, 1):
            assert found.cameras[i].intrinsics.tolist() == held[i].intrinsics.tolist()
        assert not found.covariance[:18].any()
        assert (np.diagonal(found.covariance)[18:] > 0).all()
        assert found.rms < 0.28


def fitted(truth: rigs.Rig, moments: list[dict[int, View]]) -> tuple[rig.RigCalibration, float]:
    """Fit of all of a rig's cameras, and its error of transfer at the distance of the boards, px."""
    found = rig.fit(moments, [(camera.img_size, camera.model) for camera in truth.cameras])
    distance = float(np.median(np.linalg.norm(found.board_poses[:, 3:], axis=1)))
    motions = [RigidMotion.of_vector(pose) for pose in found.poses]
    error = rigs.transfer_error(truth, rigs.Rig(found.cameras, motions), [distance] * len(truth.cameras))
    return found, error


class TestSyntheticRigs:
    def test_predicts_the_error_of_stereo_and_mixed_rigs(self) -> None:
        """200 of each are in the benchmark."""
        flat, wide = synthetic.rectilinear_cameras(6), synthetic.fisheye_cameras(6)
        errors, predicted = [], []
        for seed in range(6):
            rng = np.random.default_rng(seed)
            cameras = [flat[seed], wide[seed]] if seed % 2 else [wide[seed], wide[5 - seed]]
            truth = rigs.side_by_side(cameras, rng.uniform(1, 3))
            found, error = fitted(truth, rigs.moments(truth, BOARD, 8, 0.2, rng))
            assert found.set_aside == {}
            assert found.rms == pytest.approx(0.2 * np.sqrt(2), rel=0.1)
            errors.append(error)
            predicted.append(found.uncertainty.rms)
        assert 0.6 < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(predicted))) < 1.5

    def test_closes_a_ring_whose_neighbours_alone_share_views(self) -> None:
        flat, wide = synthetic.rectilinear_cameras(4), synthetic.fisheye_cameras(4)
        truth = rigs.ring([(wide if i % 2 else flat)[i // 2] for i in range(8)], 2.0)
        moments = rigs.moments(truth, BOARD, 24, 0.2, np.random.default_rng(1))
        assert all(not {i, (i + 4) % 8} <= set(moment) for moment in moments for i in range(8))
        found, error = fitted(truth, moments)
        assert error < 0.5
        for i, motion in enumerate(truth.motions):
            turn = RigidMotion.of_vector(found.poses[i]).r @ motion.r.T
            assert np.degrees(np.arccos(min((np.trace(turn) - 1) / 2, 1))) < 0.2

    @pytest.mark.parametrize(("count", "seeds"), [(4, 2), *thorough((4, 5), (6, 5))])
    def test_sets_a_late_view_aside_to_which_the_fit_could_bend(self, count: int, seeds: int) -> None:
        """One picture is 200 ms old while a hand moves squares of 3 cm at 5 cm/s."""
        for seed in range(seeds):
            rng = np.random.default_rng(seed)
            truth = rigs.side_by_side(synthetic.rectilinear_cameras(2), rng.uniform(1, 4))
            moments = rigs.moments(truth, BOARD, count, 0.2, rng)
            late = rigs.late_moment(truth, BOARD, 0.2 * 5 / 3, 0.2, rng)
            found, error = fitted(truth, [*moments, late])
            assert {m for m, _ in found.set_aside} == {count}
            assert error < 3 * found.uncertainty.rms

    def test_sets_another_boards_view_aside(self) -> None:
        truth = rigs.side_by_side(synthetic.rectilinear_cameras(3), 1.0)
        rng = np.random.default_rng(5)
        moments = rigs.moments(truth, BOARD, 9, 0.2, rng, shared=3)
        moments[2][1] = moments[3][1]
        found, error = fitted(truth, moments)
        assert set(found.set_aside) == {(2, 1)}
        assert error < 0.6


class TestRefusals:
    @pytest.mark.parametrize(
        ("change", "code", "words"),
        [
            (lambda m, c: (m, c[:1]), "bad_rig", "2 to 8 cameras"),
            (lambda m, c: (m, c * 5), "bad_rig", "2 to 8 cameras"),
            (lambda _, c: ([], c), "no_views", "moments"),
            (lambda m, c: ([*m, {7: m[0][0]}], c), "bad_rig", "camera 7"),
            (lambda m, c: ([{0: each[0]} for each in m], c), "unlinked", "camera 1"),
            (lambda m, c: ([{i % 2: each[i % 2]} for i, each in enumerate(m)], c), "unlinked", "camera 1"),
            (lambda m, c: (m, [c[0], (SIZE, "fishy")]), "unknown_model", "camera 1"),
        ],
    )
    def test_says_what_is_wrong(self, change: Any, code: str, words: str) -> None:
        moments, cameras = change(rigs.real_pairs(), [(SIZE, "rectilinear")] * 2)
        with pytest.raises(CalibrationError, match=words) as refused:
            rig.fit(moments, cameras)
        assert refused.value.code == code


def test_derivatives_are_those_of_the_residuals() -> None:
    """Central differences of residuals and of transfers, of a rig of three models with one camera held."""
    cameras: list[Camera] = [*synthetic.rectilinear_cameras(2), synthetic.fisheye_cameras(1)[0]]
    truth = rigs.side_by_side(cameras, 1.0)
    rng = np.random.default_rng(0)
    moments = rigs.moments(truth, BOARD, 3, 0.2, rng)
    problem = RigProblem.of(moments, cameras, [False, True, False], [1.0, 2.0, 3.0])
    k = problem.pack([c.intrinsics for c in cameras], np.array([m.vector() for m in truth.motions]))
    poses = Poses.of_vectors(np.tile([0.1, -0.2, 0.05, -4.0, -2.5, 12.0], (3, 1)))
    state = problem.at(k, poses)
    distances = np.array([10.0, 11.0, 12.0])
    transferred = transfer.jacobian(problem, k, distances)
    assert transferred.shape[2] == problem.size == 9 + 8 + 12

    def residuals(k: Array, poses: Poses) -> Array:
        return problem.residuals_of(k, poses, problem.obs)

    for i in range(problem.size):
        h = 1e-6 * max(abs(k[i]), 1e-2)
        step = np.zeros(problem.size)
        step[i] = h
        change = (residuals(k + step, poses) - residuals(k - step, poses)) / (2 * h)
        assert state.rows[i] == pytest.approx(change, rel=1e-4, abs=1e-5 * np.abs(change).max() + 1e-4)
    for i in range(6):
        step = np.zeros((3, 6))
        step[:, i] = 1e-6
        change = (residuals(k, poses.retract(step)) - residuals(k, poses.retract(-step))) / 2e-6
        assert state.rows[problem.size + i] == pytest.approx(change, rel=1e-4, abs=1e-3)


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
        cameras = [(camera.img_size, camera.model) for camera in truth.cameras]
        for errors, board_shape in ((drawn, False), (shaped, True)):
            found = rig.fit(moments, cameras, board_shape=board_shape)
            motions = [RigidMotion.of_vector(pose) for pose in found.poses]
            distances = found.working_distances.tolist()
            errors.append(rigs.transfer_error(truth, rigs.Rig(found.cameras, motions), distances))
            assert (found.board_shape is not None) == board_shape
        assert found.board_shape is not None
        assert 0.003 < found.board_shape.sag < 0.008
        flat = [{i: replace(view, flat=True) for i, view in moment.items()} for moment in moments]
        assert rig.fit(flat, cameras).board_shape is None
    assert np.median(shaped) < 0.3 < 1 < np.median(drawn)
