"""Error bars where the views allow two cameras."""

import numpy as np
import pytest

from calibsolver import Camera, View, fit, rotation
from calibsolver.fitting import focal_profile
from calibsolver.fitting.fit import refine
from tests.bench.honesty import ratios, splits
from tests.helpers.data import corner_views, external_data
from tests.helpers.marks import thorough
from tests.helpers.solver import synthetic

DECENTRED = Camera(
    "rectilinear",
    np.array([[2739.0, 0, 910], [0, 2640, 502], [0, 0, 1]]),
    [0.187, -0.56, -0.0038, 0.024, -4.6],
    (1920, 1080),
)
"""A camera whose lens is tilted: `fisheye` has no coefficients for that, and shifts the principal point."""
ALIKE = [
    [-0.09, 0.29, 0.03, -3.13, -3.42, 24.44],
    [0.10, 0.25, 1.59, 1.49, -3.38, 22.0],
    [-0.09, 0.23, 0.03, -4.36, -3.48, 23.34],
    [-0.10, 0.15, 0.03, -6.22, -3.53, 22.57],
    [-0.16, 0.25, 0.02, -4.11, -1.97, 23.17],
]
"""Rvec and tvec (squares) of boards tilted alike: distortion can stand in for the focal length."""
OTHER_OPTIMUM = Camera(
    "fisheye",
    np.array([[3450.0, 0, 560], [0, 3350, 490], [0, 0, 1]]),
    [0.43, 2.2, -10, -8],
    (1920, 1080),
)
CORNERS = np.stack([*np.meshgrid(np.arange(7.0), np.arange(7.0)), np.zeros((7, 7))], axis=-1).reshape(-1, 3)


def test_the_bars_reach_the_other_optimum() -> None:
    """The cost has two minima 700 px of focal length apart."""
    poses = np.array(ALIKE)
    views = [View(CORNERS, DECENTRED.project(CORNERS @ rotation.matrix(p[:3]).T + p[3:])) for p in poses]
    found = fit(views, DECENTRED.img_size, "fisheye")
    other = fit(views, DECENTRED.img_size, "fisheye", start=OTHER_OPTIMUM)
    assert other.camera.focal[0] > 1.2 * found.camera.focal[0]
    difference = synthetic.rms_error(found.camera, other.camera)

    assert difference < 2 * found.uncertainty().rms
    # By the curvature at the optimum alone it would be far outside.
    assert difference > 4 * refine(views, found.camera, found.poses).uncertainty().rms


@external_data
@pytest.mark.parametrize("count", [2, *thorough(4)])
def test_halves_of_a_set_with_two_optima_differ_as_predicted(count: int) -> None:
    """Fits of 12 and 13 of these views end near fx = 2,400 px or 3,100 px, as chance has it."""
    views, size = corner_views("pv_picam_1920")
    best_model = fit(views, size, board_shape=False).camera
    for halves in list(splits(len(views), None, np.random.default_rng(1)))[1 : 1 + count]:
        parts = [[views[i] for i in part] for part in halves]
        fits = [fit(part, size, "fisheye", board_shape=False) for part in parts]
        robust, _ = ratios(fits[0], fits[1])
        assert robust < 1.5
        near, far = sorted((0, 1), key=lambda i: fits[i].camera.focal[0])
        assert fits[far].camera.focal[0] > fits[near].camera.focal[0] + 400
        # The optimum of lower cost is no better a camera: the fit does not move to it.
        other = fit(parts[near], size, "fisheye", start=fits[far].camera, board_shape=False)
        assert other.avg_reprojection_error < fits[near].avg_reprojection_error
        distances = [synthetic.rms_error(best_model, c.camera) for c in (fits[near], other)]
        assert distances[0] < 0.7 * distances[1]


def test_a_focal_length_that_is_known_costs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    views, size = corner_views("opencv_left")
    expected = fit(views, size)

    def unexpected(*_: object) -> None:
        raise AssertionError("no other optimum is within reach")

    monkeypatch.setattr(focal_profile, "optimum_beside", unexpected)
    for some in (views, views[:4], views[:1]):
        fit(some, size)
    np.testing.assert_array_equal(fit(views, size).covariance, expected.covariance)
