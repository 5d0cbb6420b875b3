"""The predicted error of a projection, against the error itself."""

import numpy as np

from calibsolver import fit, models
from calibsolver.camera import pixel_grid
from calibsolver.fitting.uncertainty import projection_jacobian_rotation_free
from tests.helpers.data import corner_views
from tests.helpers.solver import intervals


def test_predicted_error_matches_the_actual_error() -> None:
    """Bounds are for sixty captures: `projection` scatters by 0.09, the mean coverage by 0.014.

    Of 60 intervals that contain the truth in 95 of 100 cases 49 or fewer do so once in ten thousand times.
    """
    found = intervals.measure("fisheye", 30, views=6)
    assert found.failed == 0
    assert 0.75 < found.projection < 1.25
    assert found.coverage.min() > 49 / 60
    assert 0.91 < found.coverage.mean() < 0.99


def test_stated_error_is_the_rms_and_the_largest_of_the_map() -> None:
    found = fit(*corner_views("opencv_left"))
    std, stated = found.projection_std(), found.uncertainty()
    np.testing.assert_allclose((stated.rms, stated.max), (np.sqrt(np.nanmean(std**2)), np.nanmax(std)))
    assert std[7, 10] < std[0, 0], "the middle of the image is known better than its corner"


def test_error_does_not_jump_at_the_edge_of_the_domain() -> None:
    """Of a fisheye lens whose domain ends inside the image in some fits only."""
    views, size = corner_views("babel_ov_plane")
    order = np.random.default_rng(3).permutation(len(views))
    stated = [fit([views[i] for i in order[:n]], size, "fisheye").uncertainty().rms for n in range(4, 9)]
    assert max(stated) < 1, stated


def test_a_turn_of_the_camera_is_no_error() -> None:
    model = models.get("rectilinear")
    d = projection_jacobian_rotation_free(model, model.start(20_000, (1280, 720)), (1280, 720), (20, 15))
    assert np.abs(d[:, 0, 2]).max() < 0.01
    assert np.abs(d[:, 1, 3]).max() < 0.01
    x = pixel_grid((1280, 720), (20, 15))[0].reshape(-1) - 639.5
    np.testing.assert_allclose(d[:, 0, 0], x / 20_000, atol=1e-4)
