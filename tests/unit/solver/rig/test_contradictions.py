"""Moments in which the board moved between the cameras: the majority is believed, others are set aside."""

import numpy as np
import pytest

from calibsolver import Board, CalibrationError, View, rig
from calibsolver.arrays import Array
from calibsolver.fitting.levenberg_marquardt import State
from calibsolver.fitting.normal_equations import Poses
from calibsolver.rig.problem import RigProblem
from calibsolver.rig.start import RigidMotion
from tests.helpers.marks import thorough
from tests.helpers.solver import rigs, synthetic

BOARD = Board((9, 6))


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
    flat = synthetic.rectilinear_cameras(12)
    truth = rigs.side_by_side([flat[int(rng.integers(12))], flat[int(rng.integers(12))]], 2.0)
    found = rig.fit(with_lies(truth, 5, bad, rng), [(c.img_size, c.model) for c in truth.cameras])
    assert {m for m, _ in found.set_aside} == set(range(5, 5 + bad))
    assert set(found.set_aside.values()) == {"contradicts"}
    motions = [RigidMotion.of_vector(pose) for pose in found.poses]
    error = rigs.transfer_error(truth, rigs.Rig(found.cameras, motions), found.working_distances.tolist())
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
    flat = synthetic.rectilinear_cameras(12)
    truth = rigs.side_by_side([flat[seed], flat[seed + 3]], 2.0)
    moments = with_lies(truth, 1, 5, np.random.default_rng(seed))
    with pytest.raises(CalibrationError, match="contradict"):
        rig.fit(moments, [(c.img_size, "rational") for c in truth.cameras])
    assert steps < 1000


@pytest.mark.parametrize("seed", [2, *thorough(9)])
def test_good_views_of_a_camera_that_is_known_badly_at_first_are_kept(seed: int) -> None:
    """In a ring a camera may have three views: its start is far from what it sees, and nothing is wrong."""
    flat, wide = synthetic.rectilinear_cameras(12), synthetic.fisheye_cameras(12)
    rng = np.random.default_rng(seed)
    cameras = [(wide if i % 2 else flat)[int(rng.integers(12))] for i in range(8)]
    moments = rigs.moments(rigs.ring(cameras, 2.0), BOARD, 24, 0.2, rng)
    found = rig.fit(moments, [(camera.img_size, camera.model) for camera in cameras])
    assert found.set_aside == {}
    assert found.rms == pytest.approx(0.2 * np.sqrt(2), rel=0.05)
