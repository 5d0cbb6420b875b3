"""Fits of real photographs against OpenCV, with fixed parameters and weights too; refusals."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from _pytest.mark import ParameterSet

from calibsolver import Board, Calibration, CalibrationError, Camera, View, fit, rotation
from calibsolver.arrays import Array
from calibsolver.fitting.constraint import Fix
from calibsolver.fitting.validation import MIN_POINTS
from tests.helpers.data import corner_views, float32
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver import populations, synthetic

RECTILINEAR = [
    "opencv_left",
    "opencv_right",
    "pv_charuco_480",
    "pv_charuco_1280",
    "pv_picam_320",
    "pv_picam_640",
    "pv_picam_960",
    "pv_picam_1920",
    "jy_left",
    "derlunz",
    "mint_isaw",
    "arizonat_fe",
]
# On these OpenCV stops in the valley, folds the image inside the views, or cancels poles with zeros.
NO_RATIONAL_REFERENCE = ("opencv_right", "pv_picam_320", "pv_picam_1920", "jy_left")
RATIONAL = [name for name in RECTILINEAR if name not in NO_RATIONAL_REFERENCE]
CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 500, 1e-14)
FISHEYE_FLAGS: Any = cv2 if hasattr(cv2, "CALIB_RECOMPUTE_EXTRINSIC") else cv2.fisheye  # OpenCV 5, and 4


def opencv(
    views: Sequence[View], size: tuple[int, int], guess: Array | None = None, **options: Any
) -> tuple[float, Array, Array]:
    """Rms, camera matrix and distortion by cv2.calibrateCamera, from a guess of the matrix if given."""
    objects, pixels = float32(views)
    rms, matrix, distortion, *_ = cv2.calibrateCamera(objects, pixels, size, guess, None, **options)
    return rms, matrix, distortion


@pytest.mark.parametrize("name", corner_sets(RECTILINEAR))
def test_rectilinear_equals_opencv(name: str) -> None:
    views, size = corner_views(name)
    rms, matrix, _ = opencv(views, size)
    ours = fit(views, size, robust=False)
    assert ours.avg_reprojection_error == pytest.approx(rms, abs=1e-4)
    np.testing.assert_allclose(ours.camera.matrix, matrix, atol=0.05)


@pytest.mark.parametrize("name", corner_sets(RATIONAL))
def test_rational_equals_opencv(name: str) -> None:
    views, size = corner_views(name)
    rms, matrix, _ = opencv(views, size, flags=cv2.CALIB_RATIONAL_MODEL, criteria=CRITERIA)
    ours = fit(views, size, "rational", robust=False)
    assert ours.avg_reprojection_error == pytest.approx(rms, abs=1e-4)
    assert ours.camera.matrix[0, 0] == pytest.approx(matrix[0, 0], abs=0.05)


@pytest.mark.parametrize("name", corner_sets(["jy_left", "pv_picam_320"]))
def test_rational_beats_opencv_in_a_narrow_valley(name: str) -> None:
    views, size = corner_views(name)
    views = views[::2]
    rms, *_ = opencv(views, size, flags=cv2.CALIB_RATIONAL_MODEL)
    assert fit(views, size, "rational", robust=False).avg_reprojection_error < rms + 1e-6


@pytest.mark.parametrize("name", corner_sets(RECTILINEAR))
def test_fisheye_equals_opencv(name: str) -> None:
    views, size = corner_views(name)
    objects = [v.object_points[None] for v in views]
    pixels = [v.image_points[None] for v in views]
    rms, matrix, _, _, _ = cv2.fisheye.calibrate(
        objects,
        pixels,
        size,
        None,
        None,
        flags=FISHEYE_FLAGS.CALIB_RECOMPUTE_EXTRINSIC | FISHEYE_FLAGS.CALIB_FIX_SKEW,
        criteria=(cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 200, 1e-10),
    )
    ours = fit(views, size, "fisheye", robust=False)
    assert ours.avg_reprojection_error == pytest.approx(rms, abs=1e-4)
    assert ours.camera.matrix[0, 0] == pytest.approx(matrix[0, 0], abs=0.05)


OPENCV_THROWS = {"babel_ov_plane": 0.49, "ocam_fisheye2": 0.33}  # px rms


@pytest.mark.parametrize("name", corner_sets(OPENCV_THROWS))
def test_fisheye_fits_views_refused_by_opencv(name: str) -> None:
    views, size = corner_views(name)
    ours = fit(views, size, "fisheye", robust=False)
    assert ours.avg_reprojection_error <= OPENCV_THROWS[name]


@pytest.mark.parametrize("name", corner_sets(["pv_charuco_480", "pv_charuco_1280", "jy_left"]))
def test_robust_fit_of_clean_views_is_the_same_camera(name: str) -> None:
    views, size = corner_views(name)
    model = "fisheye" if name == "jy_left" else "rectilinear"
    plain, robust = fit(views, size, model, robust=False), fit(views, size, model)
    np.testing.assert_allclose(robust.camera.matrix, plain.camera.matrix, rtol=0.005, atol=1e-9)
    assert robust.avg_reprojection_error < 1.02 * plain.avg_reprojection_error


def test_errors_are_over_all_points_of_the_board_in_its_shape() -> None:
    views, size = corner_views("opencv_left")
    c = fit(views, size)
    assert c.board_shape is not None
    matrix, distortion = np.array(c.camera.matrix), np.array(c.camera.distortion)
    for view, pose, residuals, error in zip(
        c.shaped(views), c.poses, c.residuals, c.view_errors, strict=True
    ):
        q, _ = cv2.projectPoints(view.object_points, pose[:3], pose[3:], matrix, distortion)
        np.testing.assert_allclose(residuals, view.image_points - q[:, 0], atol=1e-6)
        assert error == pytest.approx(rms_of(residuals), rel=1e-9)
    every = np.concatenate(c.residuals)
    assert c.avg_reprojection_error == pytest.approx(rms_of(every), rel=1e-9)
    assert c.rms_inliers == pytest.approx(rms_of(every[np.concatenate(c.used)]), rel=1e-9)


def rms_of(residuals: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(residuals**2, axis=1))))


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
@pytest.mark.parametrize("name", corner_sets(["opencv_left", "pv_charuco_480", "jy_left", "arizonat_fe"]))
def test_one_real_view_is_a_whole_camera(name: str, model: str) -> None:
    views, size = corner_views(name)
    truth = fit(views, size, "fisheye" if name == "jy_left" else model, robust=False).camera
    for view in views[:2]:
        c = fit([view], size, model)
        assert c.prior_used
        assert 0.5 < c.camera.matrix[0, 0] / truth.matrix[0, 0] < 2
        assert c.uncertainty().rms > 0.002 * size[0]


def test_truth_without_noise_is_found() -> None:
    camera = synthetic.rectilinear_cameras()[4]
    views = populations.views(camera, np.random.default_rng(2), noise=0.0, count=8)
    c = fit(views, camera.img_size, robust=False)
    np.testing.assert_allclose(c.camera.intrinsics, camera.intrinsics, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(c.view_errors, np.zeros(8), atol=1e-6)


def good_view() -> View:
    points = Board().points
    return View(points, (points[:, :2] - [4.5, 3]) * 112 + [640, 360])


IMPLAUSIBLE = {"not_believable", "no_fit", "not_converged"}


def bad_views() -> list[ParameterSet]:
    good, rng = good_view(), np.random.default_rng(0)
    p, q = good.object_points, good.image_points
    few = View(p[: MIN_POINTS - 1], q[: MIN_POINTS - 1])
    scattered = [View(p, rng.uniform(0, 700, q.shape)) for _ in range(5)]
    return [
        pytest.param([], {"no_views"}, id="no views"),
        pytest.param([good, few], {"too_few_points"}, id="too few points"),
        pytest.param([View(p[:8], q[:8])], {"degenerate"}, id="points on a line"),
        pytest.param([View(p, np.full_like(q, 300.0))], {"degenerate"}, id="points in one place"),
        pytest.param([View(p + rng.normal(size=p.shape), q)], {"not_planar"}, id="not planar"),
        pytest.param([View(p, 1e300 * q)], {"out_of_range"}, id="pixels out of range"),
        pytest.param([View(1e200 * p, q)], {"out_of_range"}, id="board out of range"),
        pytest.param(scattered[:1], IMPLAUSIBLE, id="one view of scattered points"),
        pytest.param(scattered, IMPLAUSIBLE, id="five views of scattered points"),
    ]


@pytest.mark.parametrize(("views", "codes"), bad_views())
def test_bad_views_are_refused_with_a_reason(views: list[View], codes: set[str]) -> None:
    with pytest.raises(CalibrationError) as caught:
        fit(views, (1280, 720), "fisheye")
    assert caught.value.code in codes


def test_sizes_of_no_image_are_refused() -> None:
    for size in ((0, 720), (100_000, 720), None, 1280, "1280x720", (1280, 720, 3)):
        with pytest.raises(CalibrationError) as caught:
            fit([good_view()], size)  # type: ignore[arg-type]
        assert caught.value.code == "out_of_range"


def test_views_may_come_one_by_one() -> None:
    views, size = corner_views("opencv_left")
    one_by_one = fit((view for view in views), size)  # type: ignore[arg-type]
    np.testing.assert_array_equal(one_by_one.camera.matrix, fit(views, size).camera.matrix)


def test_record_has_the_stored_members() -> None:
    views, size = corner_views("opencv_left")
    found = fit(views, size)
    record = found.record()
    assert " ".join(record) == (
        "img_size camera_matrix distortion_coefficients distortion_model avg_reprojection_error uncertainty "
        "systematic board_shape"
    )
    np.testing.assert_array_equal(Camera.from_record(record).intrinsics, found.camera.intrinsics)
    assert 0 < record["uncertainty"]["rms"] < record["uncertainty"]["max"]
    assert record["systematic"] == found.inflation


def test_summary_names_every_figure() -> None:
    views, size = corner_views("opencv_left")
    calibration = fit(views, size)
    fx = calibration.camera.intrinsics[0]
    assert f"fx={fx:.2f}" in repr(calibration)
    rows = dict(row.split("  ", 1) for row in calibration.summary().splitlines())
    assert list(rows) == [
        *["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
        "camera",
        "views",
        "corners",
        "rms",
        "uncertainty",
    ]
    value, sigma = map(float, rows["fx"].split(" ± "))
    assert value == pytest.approx(fx, abs=0.006)
    assert sigma == pytest.approx(np.sqrt(calibration.covariance[0, 0]), abs=0.006)
    assert calibration._repr_html_().count("<tr>") == len(rows)


def test_summary_counts_views_left_out() -> None:
    views, size = corner_views("opencv_left")
    row = View(views[0].object_points[:6], views[0].image_points[:6])
    calibration = fit([*views, row], size)
    assert f"{len(views)} of {len(views) + 1}; left out: 1 degenerate" in calibration.summary()


def test_points_outside_the_image_are_refused_by_view() -> None:
    views, (w, h) = corner_views("opencv_left")
    with pytest.raises(CalibrationError, match=r"view 0 has points outside the image of 320 x 240 px") as why:
        fit(views, (w // 2, h // 2))
    assert why.value.code == "outside_image"
    shifted = views[2].image_points + np.array([w - views[2].image_points[:, 0].max() + 3.0, 0.0])
    fit([*views[:2], View(views[2].object_points, shifted), *views[3:]], (w, h))  # by a detector's error


SETS = corner_sets(["opencv_left", "jy_left", "pv_charuco_480", "pv_picam_640", "derlunz"])
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


def assert_is_opencvs(ours: Calibration, name: str, flags: int, guess: np.ndarray | None) -> None:
    rms, matrix, distortion = opencv(*some_views(name), guess, flags=flags, criteria=CRITERIA)
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
