"""Cross-validation of rigs: the noise where it is known, real corners, and what cannot be left out."""

import numpy as np
import pytest

from calibsolver import Board, rig
from tests.helpers.solver import rigs, synthetic

BOARD = Board((9, 6))


def test_error_on_moments_left_out_is_the_noise_of_corners() -> None:
    truth = rigs.side_by_side(synthetic.rectilinear_cameras(3), 1.0)
    moments = rigs.moments(truth, BOARD, 12, 0.2, np.random.default_rng(3))
    found = rig.fit(moments, [(camera.img_size, camera.model) for camera in truth.cameras])
    left_out = rig.held_out_rms(moments, found)
    assert left_out == pytest.approx(0.2 * np.sqrt(2), rel=0.05)
    assert rig.held_out_rms(moments[:1], found) is None, "nothing would link the cameras"


def test_real_pair_predicts_moments_it_never_saw() -> None:
    """Pair 09 is numbered from both ends, in the part that is left out as well as in training."""
    moments = rigs.real_pairs()
    found = rig.fit(moments, [(rigs.REAL_SIZE, "rectilinear")] * 2)
    left_out = rig.held_out_rms(moments, found)
    assert left_out is not None
    assert found.rms < left_out < 1.1 * found.rms
    drawn = rig.fit(moments, [(rigs.REAL_SIZE, "rectilinear")] * 2, board_shape=False)
    assert left_out < 0.98 * (rig.held_out_rms(moments, drawn) or 0), "the board is not as drawn"
    assert found.uncertainty.rms < drawn.uncertainty.rms
    held = rig.fit(moments, found.cameras)
    assert found.rms < (rig.held_out_rms(moments, held) or np.inf) < left_out
