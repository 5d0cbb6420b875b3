"""The error that an export states is not exceeded anywhere, whichever way the picture is turned."""

import ast
import base64
import contextlib
import io
import time
from functools import cache
from typing import Any

import numpy as np
import pytest

from calibsolver import (
    Board,
    CalibrationError,
    Camera,
    DeadlineError,
    View,
    deadline,
    fit,
    formats,
    image_transform,
    models,
)
from calibsolver.fitting.levenberg_marquardt import Options, Problem
from calibsolver.fitting.normal_equations import Poses
from calibsolver.fitting.observations import Observations
from calibsolver.formats import ExportSource, ModelConstraint
from calibsolver.formats.convert import share_behind
from calibsolver.formats.ray_fit import fit_to_rays, sampled_rays
from tests.helpers.data import corner_views, on_board
from tests.helpers.marks import thorough
from tests.helpers.solver import hands, populations, synthetic
from tests.helpers.solver.export_sources import IMG_SIZE, captured, image_rays, subject, written

GRID = (100, 75)
TURNS = {
    "upright": image_transform.identity,
    "turned": lambda size: image_transform.rotate(size, 90),
    "mirrored": image_transform.mirror,
}
"""Transforms of pictures of a size."""


@pytest.mark.parametrize("model", models.NAMES)
@pytest.mark.parametrize("cropped", [False, True])
def test_stated_error_is_not_exceeded_on_a_grid_of_valid_rays(model: str, cropped: bool) -> None:
    part = image_transform.crop(IMG_SIZE, (100, 60), (800, 500))
    source = formats.transform_source(subject(model), part) if cropped else subject(model)
    grids = [image_rays(source.camera, *GRID, border=border) for border in (0.0, 0.5)]
    for name in ("kalibr", "gyroflow", "gltf", "photonvision", "artoolkit", "mrcal"):
        try:
            conversion = formats.FORMATS[name].convert(source)
        except CalibrationError:
            continue  # it cannot hold this camera
        other = models.get(conversion.camera.model)
        angle = other.domain_half_angle(np.asarray(conversion.camera.distortion))
        if models.get(model).max_angle > other.max_angle:
            angle = min(angle, other.max_angle)
        for rays, q in grids:
            covered = rays[:, 2] > np.cos(angle)
            away = np.linalg.norm(conversion.camera.project(rays[covered]) - q[covered], axis=1)
            assert away.max() <= conversion.error + 1e-9, name


CENTRE, CORNER = ((100, 60), (800, 500)), ((0, 0), (300, 200))


@pytest.mark.parametrize("model", models.NAMES)
@pytest.mark.parametrize(("part", "coverage"), [(CENTRE, 0.99), (CORNER, 0.6)])
def test_crop_is_held_as_the_whole_picture_is(
    model: str, part: tuple[tuple[int, int], tuple[int, int]], coverage: float
) -> None:
    # Most points of the views lie outside; in the corner too few are left for a fit.
    crop = image_transform.crop(IMG_SIZE, *part)
    for name in ("kalibr", "mrcal", "colmap", "opensfm", "photonvision"):
        cropped = formats.write(subject(model), name, crop)
        assert cropped.error <= max(1.25 * written(model, name).error, 1.1), name
        assert cropped.coverage > coverage, name


def fisheye(fx: float) -> Camera:
    k = np.array([fx, 1.002 * fx, 660, 450, 0.02, -0.01, 0.003, -0.001])
    return Camera.from_intrinsics("fisheye", k, (1280, 960))


@cache
def wide() -> ExportSource:
    """A fisheye whose views reach beyond what a planar model can hold, calibrated from them."""
    camera, board = fisheye(420), Board()
    views = captured(camera, board, count=12, noise=0.15)
    return ExportSource(fit(views, camera.img_size, "fisheye").camera, views, board)


@cache
def photographed() -> ExportSource:
    """The calibration of real photographs, outliers among their corners."""
    views, size = corner_views("opencv_left")
    board, _, ours = on_board(views)
    return ExportSource(fit(ours, size).camera, ours, board)


def inputs(file: formats.ExportedFile) -> dict[str, Any]:
    """mrcal's optimization inputs of a .cameramodel."""
    lines = [line for line in file.content.decode().splitlines() if not line.lstrip().startswith("#")]
    packed = ast.literal_eval("\n".join(lines))["optimization_inputs"]
    with np.load(io.BytesIO(base64.b85decode(packed)), allow_pickle=False) as arrays:
        return dict(arrays)


def rms_before_and_after(arrays: dict[str, Any]) -> tuple[float, float]:
    """Rms, px, of the points that count, as they are in the file and at the least-squares optimum.

    As mrcal.optimize() has it: no regularisation, no further outlier rejection, intrinsics and frames free.
    """
    k = arrays["intrinsics"][0]
    model = models.get("rational" if len(k) == 12 else "rectilinear")
    size = tuple(int(n) for n in arrays["imagersizes"][0])
    down, across = arrays["observations_board"].shape[1:3]
    points = np.stack([*np.meshgrid(np.arange(across), np.arange(down)), np.zeros((down, across))], axis=2)
    views = []
    for seen in arrays["observations_board"]:
        good = seen[..., 2] > 0
        views.append(View(points[good], seen[good][:, :2]))
    obs = Observations.of(views)
    problem, weights = Problem(model, obs, (size[0], size[1])), obs.mask.astype(np.float64)
    begun = problem.at(k, Poses.of_vectors(arrays["frames_rt_toref"]))
    with np.errstate(all="ignore"):
        state = problem.solve(begun, weights, Options(with_prior=False, iterations=400, tolerance=1e-15))
    rms = [float(np.sqrt(each.square[obs.mask].mean())) for each in (begun, state)]
    return rms[0], rms[1]


@pytest.mark.parametrize("turn", ["upright", "turned", *thorough("mirrored")])
def test_mrcal_inputs_of_a_wide_fisheye_are_at_their_optimum(turn: str) -> None:
    file = formats.write(wide(), "mrcal", TURNS[turn](wide().camera.img_size))
    before, after = rms_before_and_after(inputs(file))
    assert before < 1.01 * after
    assert after < 0.25
    assert file.error == pytest.approx(formats.FORMATS["mrcal"].convert(wide()).error, rel=1e-9)


def test_mrcal_inputs_of_real_photographs_are_at_their_optimum() -> None:
    arrays = inputs(formats.write(photographed(), "mrcal"))
    before, after = rms_before_and_after(arrays)
    assert before < 1.01 * after
    assert arrays["calobject_warp"].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("name", ["kalibr", "gyroflow", "artoolkit"])
def test_turned_picture_is_converted_to_the_turned_camera(name: str) -> None:
    upright = written("rational", name)
    for turn in ("turned", "mirrored"):
        turned = formats.write(subject("rational"), name, TURNS[turn](IMG_SIZE))
        assert turned.error == pytest.approx(upright.error, rel=1e-9)
        assert turned.coverage == upright.coverage


def test_kalibr_file_with_a_centre_outside_is_refused() -> None:
    right = image_transform.crop(IMG_SIZE, (700, 0), (580, 720))
    with pytest.raises(CalibrationError, match="Kalibr refuses a principal point"):
        formats.write(subject("fisheye"), "kalibr", right)
    assert formats.write(subject("fisheye"), "ros", right).error == 0


def test_kalibr_file_of_a_camera_that_it_cannot_hold_does_not_turn_it() -> None:
    """In a rig that would contradict the poses. A fit of keypoints was 2.7 px off on average."""
    k = np.array([600.0, 602, 650, 370, -0.28, 0.09, 0.001, -0.0005, -0.01])
    camera = Camera.from_intrinsics("rectilinear", k, IMG_SIZE)
    conversion = formats.FORMATS["kalibr"].convert(ExportSource(camera))
    rays, q = image_rays(camera, 33, 25)
    away = conversion.camera.project(rays) - q
    assert np.linalg.norm(away.mean(axis=0)) < 0.3
    assert np.linalg.norm(away, axis=1).max() <= conversion.error < 6


@pytest.mark.parametrize(
    "name", ["opencv-yaml", "opencv-json", "ros", "kalibr", "colmap", "opensfm", "gyroflow"]
)
def test_files_say_where_their_tools_cannot_project(name: str) -> None:
    warning = formats.write(ExportSource(fisheye(280)), name).warning
    assert "cannot project rays at 90 degrees" in str(warning)
    assert written("rectilinear", "ros").warning is None


def test_file_says_where_wpical_is_no_reader() -> None:
    for model in models.NAMES:
        warning = written(model, "calibdb").warning
        assert (warning is None) == (model in ("rectilinear", "rational"))
        assert warning is None or "WPIcal" in warning


@pytest.mark.parametrize("number", [2, 5, 8])
def test_another_model_is_fitted_in_the_boards_shape(number: int) -> None:
    """A board bent by 0.5 %: fitted as drawn, the fisheye camera of the file would be 3.6 to 6 px off."""
    camera = synthetic.rectilinear_cameras()[number]
    views = populations.views(camera, np.random.default_rng(0), count=8, hand=hands.BENT)
    own = fit(views, camera.img_size).camera
    conversion = formats.FORMATS["gyroflow"].convert(ExportSource(own, tuple(views)))
    assert conversion.camera.model == "fisheye"
    assert synthetic.rms_error(camera, conversion.camera) < 0.4


NARROW = synthetic.rectilinear_cameras()[6]


@pytest.mark.parametrize("size", [(1280, 1), (15, 720)])
def test_part_below_16_px_is_refused(size: tuple[int, int]) -> None:
    part = image_transform.crop(NARROW.img_size, (0, 0), size)
    with pytest.raises(CalibrationError, match=f"{size[0]} x {size[1]} px") as refused:
        formats.write(ExportSource(NARROW), "lensfun", part)
    assert refused.value.code == "not_representable"


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
def test_small_part_is_written_with_a_finite_error_or_refused(name: str) -> None:
    part = image_transform.crop(NARROW.img_size, (0, 0), (16, 16))
    error = coverage = 0.0
    begun = time.thread_time()
    short = deadline.limit(lambda: begun + 0.3 - time.thread_time())
    with short, contextlib.suppress(CalibrationError, DeadlineError):
        written = formats.write(ExportSource(NARROW), name, part)
        error, coverage = written.error, written.coverage
    assert np.isfinite([error, coverage]).all()


def test_share_behind_of_a_fisheye_without_a_ray_is_none() -> None:
    """Of a lens that folds at once, far from its principal point, no pixel has a ray."""
    k = np.array([0.5, 0.5, 1e7, 1e7, -9e3, 0, 0, 0])
    assert share_behind(Camera.from_intrinsics("fisheye", k, (1280, 720))) == 0.0


def test_unified_camera_model_contains_every_plane() -> None:
    """The ray fit finds a camera of another model if there is one that draws the same picture."""
    k = np.array([598.761, 595.207, 648.835, 347.389, -0.17478, 0.05, 0, 0, 0])
    camera = Camera.from_intrinsics("rectilinear", k, (1280, 720))
    found = fit_to_rays(camera, ModelConstraint("omnidirectional"))
    rays, q = sampled_rays(camera, models.get("omnidirectional").max_angle)
    assert np.abs(found.project(rays.T) - q.T).max() < 1e-3  # px
