"""Fits with fixed parameters and with weights."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from calibsolver import Calibration, CalibrationError, Camera, View, fit, rotation
from calibsolver.fitting.constraint import Fix
from tests.helpers.data import corner_views, float32
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver import populations, synthetic

SETS = corner_sets(["opencv_left", "jy_left", "pv_charuco_480", "pv_picam_640", "derlunz"])
CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-14)
CASES: dict[str, tuple[Fix, int]] = {
    "center": ("center", cv2.CALIB_FIX_PRINCIPAL_POINT),
    "aspect": ("aspect", cv2.CALIB_FIX_ASPECT_RATIO),
    "tangential and k3": (("tangential", "k3"), cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3),
    "pinhole": (
        ("k1", "k2", "k3", "tangential"),
        cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    ),
}


def some_views(name: str) -> tuple[list[View], tuple[int, int]]:
    views, size = corner_views(name)
    return views[:: 1 + len(views) // 20], size


def assert_is_opencvs(ours: Calibration, name: str, flags: int, matrix: np.ndarray | None) -> None:
    views, size = some_views(name)
    objects, pixels = float32(views)
    rms, matrix, distortion, _, _ = cv2.calibrateCamera(
        objects, pixels, size, matrix, None, flags=flags, criteria=CRITERIA
    )
    assert ours.avg_reprojection_error == pytest.approx(rms, abs=1e-5)
    np.testing.assert_allclose(ours.camera.matrix, matrix, atol=0.002)
    np.testing.assert_allclose(ours.camera.distortion, distortion.ravel()[:5], atol=1e-4)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", SETS)
def test_fixed_parameters_equal_opencv(name: str, case: str) -> None:
    views, size = some_views(name)
    fix, flags = CASES[case]
    square_pixels = np.array([[1000.0, 0, (size[0] - 1) / 2], [0, 1000.0, (size[1] - 1) / 2], [0, 0, 1]])
    ours = fit(views, size, robust=False, fix=fix)
    assert_is_opencvs(ours, name, flags, square_pixels if case == "aspect" else None)


@pytest.mark.parametrize("name", SETS)
def test_focal_lengths_of_a_start_are_held(name: str) -> None:
    views, size = some_views(name)
    free = fit(views, size, robust=False).camera
    start = Camera.from_intrinsics(free.model, free.intrinsics * (1.01, 1.01, *[1] * 7), size)
    flags = cv2.CALIB_FIX_FOCAL_LENGTH | cv2.CALIB_USE_INTRINSIC_GUESS
    ours = fit(views, size, robust=False, start=start, fix=("fx", "fy"))
    np.testing.assert_array_equal(ours.camera.intrinsics[:2], start.intrinsics[:2])
    assert_is_opencvs(ours, name, flags, start.matrix.copy())
    again = fit(views, size, robust=False, fix={"fx": start.intrinsics[0], "fy": start.intrinsics[1]})
    np.testing.assert_allclose(again.camera.intrinsics, ours.camera.intrinsics, atol=1e-4)


@pytest.mark.parametrize("model", ["rectilinear", "fisheye", "rational", "omnidirectional"])
@pytest.mark.parametrize("name", ["opencv_left", *thorough("jy_left")])
def test_robust_fit_holds_the_value_and_has_no_variance_there(name: str, model: str) -> None:
    views, size = corner_views(name)
    found = fit(views, size, model, fix={"cx": size[0] / 2 + 3, "aspect": 1.0})
    k, deviations = found.camera.intrinsics, np.sqrt(np.diagonal(found.covariance))
    assert k[2] == size[0] / 2 + 3
    assert k[0] == pytest.approx(k[1], rel=1e-12)
    assert deviations[2] == 0
    assert deviations[0] == pytest.approx(deviations[1], rel=1e-9)
    assert (np.delete(deviations, 2) > 0).all()
    assert found.fixed == ("cx", "aspect") == tuple(found.record()["fixed"])
    assert "(fixed)" in found.summary()


def test_covariance_of_fixed_and_weighted_fits_holds_over_simulations() -> None:
    camera = synthetic.rectilinear_cameras()[4]
    clean = populations.views(camera, np.random.default_rng(7), noise=0.0)
    k = camera.intrinsics
    fixed = {"aspect": k[0] / k[1], "cx": k[2], "k3": k[8]}
    free = [0, 3, 4, 5, 6, 7]
    rng, squares = np.random.default_rng(1), []
    for _ in range(40):
        noisy = []
        for view in clean:
            sigma = np.where(np.arange(len(view)) % 3 == 0, 1.0, 0.2)
            noise = sigma[:, None] * rng.normal(size=(len(view), 2))
            noisy.append(View(view.object_points, view.image_points + noise, sigma**-2.0))
        found = fit(noisy, camera.img_size, fix=fixed)
        off = (found.camera.intrinsics - k)[free]
        squares.append(off @ np.linalg.solve(found.covariance[np.ix_(free, free)], off))
    assert np.mean(squares) == pytest.approx(6, abs=3 * np.sqrt(12 / 40))


def test_weights_count_as_repeated_points() -> None:
    views, size = corner_views("opencv_left")
    doubled = [v.subset(np.append(np.arange(len(v)), np.arange(0, len(v), 2))) for v in views]
    weighted = [replace(v, weights=np.where(np.arange(len(v)) % 2 == 0, 2.0, 1.0)) for v in views]
    one, other = fit(weighted, size, robust=False), fit(doubled, size, robust=False)
    np.testing.assert_allclose(one.camera.intrinsics, other.camera.intrinsics, rtol=1e-6, atol=1e-6)
    plain = fit(views, size, robust=False)
    assert abs(one.camera.intrinsics[0] - plain.camera.intrinsics[0]) > 0.01
    residual = views[3].image_points - one.camera.project(
        views[3].object_points @ rotation.matrix(one.poses[3, :3]).T + one.poses[3, 3:]
    )
    np.testing.assert_allclose(one.residuals[3], residual, atol=1e-9)  # in px, not weighted


def test_equal_weights_change_nothing() -> None:
    views, size = corner_views("opencv_left")
    equal = [replace(v, weights=5.0) for v in views]
    plain, same = (fit(each, size, robust=False).camera for each in (views, equal))
    np.testing.assert_array_equal(same.intrinsics, plain.intrinsics)


@pytest.mark.parametrize(
    ("fix", "code", "says"),
    [
        ("focal", "unknown_parameter", "only fx, fy, cx, cy"),
        ("fx", "no_value", "fx needs a value"),
        ({"center": 3.0}, "no_value", "pass cx and cy"),
        ({"k1": float("nan")}, "no_value", "pass a number"),
        ({"fx": -2.0}, "no_value", "pass a positive number"),
        ({"fx": 500.0, "fy": 500.0, "aspect": None}, "no_value", "not all three"),
        ({"fx": 500.0, "fy": 500.0, "center": None, "tangential": None, "k1": 0, "k2": 0, "k3": 0},
         "no_value", "nothing is left"),
    ],
)  # fmt: skip
def test_what_cannot_be_fixed_is_refused(fix: Fix, code: str, says: str) -> None:
    views, size = corner_views("opencv_left")
    with pytest.raises(CalibrationError, match=says) as raised:
        fit(views, size, fix=fix)
    assert raised.value.code == code


def test_names_without_values_refuse_a_start_of_another_model() -> None:
    views, size = corner_views("opencv_left")
    other = fit(views, size, "fisheye").camera
    with pytest.raises(CalibrationError, match="no rectilinear camera"):
        fit(views, size, fix="center", start=other)
    assert fit(views, size, fix={"k3": 0.0}, start=other).camera.distortion[4] == 0


@pytest.mark.parametrize("weights", [np.ones(3), np.zeros(54), np.full(54, np.nan), -1.0])
def test_weights_that_make_no_sense_are_refused(weights: np.ndarray | float) -> None:
    views, _ = corner_views("opencv_left")
    with pytest.raises(ValueError, match="weights must be"):
        View(views[0].object_points, views[0].image_points, weights)
