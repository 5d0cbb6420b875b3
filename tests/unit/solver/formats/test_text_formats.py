"""Files of text, read back by the tools they are for, or by what those document."""

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable

import cv2
import numpy as np
import pycolmap
import pytest
import yaml

from calibsolver import CalibrationError, Camera, formats, models
from calibsolver.arrays import Array
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportedFile, ExportSource
from tests.helpers.solver.export_sources import IMG_SIZE, image_rays, subject, written

ROUGH = 0.01
"""px: how far a tool's projection may be from ours beyond what the file says of itself."""


def off(model: str, file: ExportedFile, project: Callable[[Array], Array]) -> None:
    """Assert that a tool projects the rays of the image where we saw them, or as far off as the file says.

    Only rays ahead of the camera: most tools divide by the depth, whatever the model.
    """
    rays, q = image_rays(subject(model).camera, 65, 49, border=0.5)
    ahead = rays[:, 2] > 0.02
    there = project(rays[ahead])
    seen = np.isfinite(there).all(axis=1)
    assert seen.mean() >= file.coverage - 0.01
    away = np.linalg.norm(there[seen] - q[ahead][seen], axis=1)
    away = away[away < np.quantile(away, min(file.coverage + 0.002, 1))] if file.coverage < 1 else away
    assert away.max() <= file.error + ROUGH
    if ahead.all() and file.coverage == 1:
        assert away.max() >= 0.99 * file.error - ROUGH, "the file says more than is the case"


def opencv(matrix: Array, d: Array, fisheye: bool = False) -> Callable[[Array], Array]:
    def project(rays: Array) -> Array:
        zero = np.zeros(3)
        if fisheye:
            q = cv2.fisheye.projectPoints(rays[:, None], zero, zero, matrix, d.reshape(4, 1))[0]
        else:
            q = cv2.projectPoints(rays, zero, zero, matrix, d)[0]
        return np.asarray(q.reshape(-1, 2), dtype=np.float64)

    return project


@pytest.mark.parametrize("model", models.NAMES)
@pytest.mark.parametrize("name", ["opencv-yaml", "opencv-json"])
def test_file_storage_reads_every_camera_to_the_last_bit(name: str, model: str) -> None:
    file, camera = written(model, name), subject(model).camera
    flags = cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
    storage = cv2.FileStorage(file.content.decode(), flags)
    k, d = storage.getNode("camera_matrix").mat(), storage.getNode("distortion_coefficients").mat()
    assert np.array_equal(k, camera.matrix)
    xi = storage.getNode("xi").mat()
    full = d.ravel() if xi is None else np.append(xi.ravel(), d.ravel())
    assert np.array_equal(full, camera.distortion)
    assert (storage.getNode("image_width").real(), storage.getNode("image_height").real()) == IMG_SIZE
    assert storage.getNode("avg_reprojection_error").real() == subject(model).rms
    assert storage.getNode("fisheye_model").real() == (model == "fisheye")
    assert file.error == 0
    if model in ("rectilinear", "rational", "fisheye"):
        off(model, file, opencv(k, d, model == "fisheye"))
    else:
        rays, q = image_rays(camera)
        there = cv2.omnidir.projectPoints(rays[:, None], np.zeros(3), np.zeros(3), k, float(xi[0, 0]), d)[0]
        assert np.abs(there.reshape(-1, 2) - q).max() < ROUGH


@pytest.mark.parametrize("model", models.NAMES)
def test_ros_yaml_has_full_precision(model: str) -> None:
    file = written(model, "ros")
    data = yaml.safe_load(file.content)
    size = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}[data["distortion_model"]]
    shapes = {"camera": (3, 3), "rectification": (3, 3), "projection": (3, 4)}
    shapes = {f"{name}_matrix": shape for name, shape in shapes.items()}
    for name, shape in (shapes | {"distortion_coefficients": (1, size)}).items():
        assert (data[name]["rows"], data[name]["cols"]) == shape
        assert len(data[name]["data"]) == np.prod(shape)
    d = np.array(data["distortion_coefficients"]["data"])
    assert all(isinstance(v, float) for v in [*d.tolist(), *data["camera_matrix"]["data"]])
    assert (data["image_width"], data["image_height"]) == IMG_SIZE
    assert data["camera_name"].isascii()
    k = np.array(data["camera_matrix"]["data"]).reshape(3, 3)
    if model != "omnidirectional":
        # ROS's own writer keeps six digits, which moves projections: ours must not
        assert np.array_equal(k, subject(model).camera.matrix)
        assert np.array_equal(d, subject(model).camera.distortion)
    off(model, file, opencv(k, d, data["distortion_model"] == "equidistant"))


@pytest.mark.parametrize("model", models.NAMES)
def test_kalibr_coefficients_are_refitted(model: str) -> None:
    file = written(model, "kalibr")
    cam = yaml.safe_load(file.content)["cam0"]
    # what aslam_cv's parameter reader asserts
    assert cam["camera_model"] in ("pinhole", "omni")
    assert cam["distortion_model"] in ("radtan", "equidistant")
    assert len(cam["distortion_coeffs"]) == 4
    assert all(isinstance(n, int) for n in cam["resolution"])
    assert all(isinstance(v, float) for v in [*cam["intrinsics"], *cam["distortion_coeffs"]])
    assert cam["rostopic"].startswith("/")
    *xi, fu, fv, pu, pv = cam["intrinsics"]
    assert len(xi) == (cam["camera_model"] == "omni")
    k, d = np.array([[fu, 0, pu], [0, fv, pv], [0, 0, 1]]), np.array(cam["distortion_coeffs"])
    if xi:
        full = Camera("omnidirectional", k, np.append(xi, d), IMG_SIZE)
        off(model, file, full.project)
    else:
        off(model, file, opencv(k, d, cam["distortion_model"] == "equidistant"))
    if model == "rectilinear":
        mine = subject(model)
        cut = Camera(model, mine.camera.matrix, np.append(mine.camera.distortion[:4], 0), IMG_SIZE)
        refitted = Camera(model, k, np.append(d, 0), IMG_SIZE)
        assert reprojection_score(refitted, mine.views).rms < 1.05 * mine.rms
        assert reprojection_score(cut, mine.views).rms > 2 * mine.rms, "without the refit"


@pytest.mark.parametrize("model", models.NAMES)
def test_colmap_projects_half_a_pixel_further(model: str) -> None:
    file = written(model, "colmap")
    fields = file.content.decode().splitlines()[-1].split()
    assert fields[0] == "1"
    assert [int(n) for n in fields[2:4]] == list(IMG_SIZE)
    params = [float(n) for n in fields[4:]]
    camera = pycolmap.Camera(model=fields[1], width=IMG_SIZE[0], height=IMG_SIZE[1], params=params)

    def project(rays: Array) -> Array:
        found = [camera.img_from_cam(ray) for ray in rays]
        return np.array([[np.nan, np.nan] if q is None else q for q in found]) - 0.5

    off(model, file, project)
    assert params[2] == pytest.approx(subject(model).camera.matrix[0, 2] + 0.5, abs=20)
    if model in ("rectilinear", "fisheye"):
        assert params[2] == subject(model).camera.matrix[0, 2] + 0.5


@pytest.mark.parametrize("model", models.NAMES)
def test_opensfm_is_centred_and_scaled_by_the_larger_side(model: str) -> None:
    file = written(model, "opensfm")
    ((name, data),) = json.loads(file.content).items()
    assert name == subject(model).name
    names = {"brown": ("k1", "k2", "p1", "p2", "k3"), "fisheye_opencv": ("k1", "k2", "k3", "k4")}
    d = np.array([data[name] for name in names[data["projection_type"]]])
    w, h = data["width"], data["height"]
    fx, fy, cx, cy = (max(w, h) * data[name] for name in ("focal_x", "focal_y", "c_x", "c_y"))
    k = np.array([[fx, 0, cx + (w - 1) / 2], [0, fy, cy + (h - 1) / 2], [0, 0, 1]])
    # OpenSfM documents both with OpenCV's formulas.
    off(model, file, opencv(k, d, data["projection_type"] == "fisheye_opencv"))


@pytest.mark.parametrize("model", models.NAMES)
def test_gyroflow_uses_the_written_principal_point(model: str) -> None:
    file = written(model, "gyroflow")
    data = json.loads(file.content)
    assert data["asymmetrical"] is True
    assert data["distortion_model"] == "opencv_fisheye"
    assert data["calib_dimension"] == {"w": 1280, "h": 720}
    assert {"calibrator_version", "camera_brand", "camera_model", "lens_model"} <= data.keys()
    params = data["fisheye_params"]
    k, d = np.array(params["camera_matrix"]), np.array(params["distortion_coeffs"])
    off(model, file, opencv(k, d, fisheye=True))
    # without the flag the program puts the principal point into the middle
    if model == "fisheye":
        k[:2, 2] = 640, 360
        rays, q = image_rays(subject(model).camera)
        assert np.abs(opencv(k, d, fisheye=True)(rays) - q).max() > 5


@pytest.mark.parametrize("model", models.NAMES)
def test_photonvision_holds_the_keypoints(model: str) -> None:
    file, mine = written(model, "photonvision"), subject(model)
    data = json.loads(file.content)
    k = np.array(data["cameraIntrinsics"]["data"]).reshape(3, 3)
    d = np.array(data["distCoeffs"]["data"])
    assert data["cameraIntrinsics"]["type"] == data["distCoeffs"]["type"] == 6
    assert data["distCoeffs"]["cols"] == len(d)
    off(model, file, opencv(k, d))
    assert len(data["observations"]) == len(mine.views)
    for seen, view in zip(data["observations"], mine.views, strict=True):
        q = np.array([[p["x"], p["y"]] for p in seen["locationInImageSpace"]])
        assert np.array_equal(q, view.image_points)
        e = np.array([[p["x"], p["y"]] for p in seen["reprojectionErrors"]])
        # the pose that is written is the one that these residuals belong to
        rotation = seen["optimisedCameraToObject"]["rotation"]["quaternion"]
        w, v = rotation["W"], np.array([rotation[a] for a in "XYZ"])
        angle = 2 * np.arctan2(np.linalg.norm(v), w)
        rvec = v / np.linalg.norm(v) * angle
        t = np.array([seen["optimisedCameraToObject"]["translation"][a] for a in "xyz"])
        back = cv2.projectPoints(view.object_points, rvec, t, k, d)[0].reshape(-1, 2)
        assert np.abs(back - q - e).max() < 1e-6


@pytest.mark.parametrize(
    ("model", "keypoints"), [("fisheye", True), ("fisheye", False), ("omnidirectional", True)]
)
def test_perspective_model_of_a_wide_lens_fits_to_80_degrees(model: str, keypoints: bool) -> None:
    """All the rays of the image within, far denser than the conversion looks; of what is beyond no word."""
    mine = subject(model)
    file = formats.write(mine if keypoints else ExportSource(mine.camera), "photonvision")
    data = json.loads(file.content)
    k, d = np.array(data["cameraIntrinsics"]["data"]).reshape(3, 3), np.array(data["distCoeffs"]["data"])
    assert file.coverage == (image_rays(mine.camera, 129, 97, border=0.5)[0][:, 2] > np.cos(1.4)).mean() > 0.8
    rays, q = image_rays(mine.camera, 257, 145)
    within = rays[:, 2] > np.cos(1.4)
    away = np.linalg.norm(opencv(k, d)(rays[within]) - q[within], axis=1)
    assert 0.8 * file.error - ROUGH <= away.max() <= 1.01 * file.error + ROUGH
    assert file.error < (5 if keypoints else 1)
    assert f"holds {100 * file.coverage:.0f} % of the image" in str(file.warning)


def test_inexact_text_formats_carry_the_warning() -> None:
    for name in ("ros", "colmap", "mrcal", "gyroflow", "opensfm", "lensfun", "gltf", "photonvision"):
        file = written("omnidirectional", name)
        assert file.error > 0.1
        assert f"{file.error:.2f} px off".encode() in file.content, name
    for name in formats.FORMAT_NAMES:
        file = written("rectilinear", name)
        assert (file.warning is not None) == (file.error > formats.MAX_INVISIBLE_PX)


@pytest.mark.parametrize("name", ["a\x1b[31m & <b>\x00", "\ud800\ufffe", "]]>--", "\x07", "後置 \U0001f4f7"])
def test_lensfun_escapes_the_camera_name(name: str) -> None:
    mine = subject("rectilinear")
    file = formats.write(ExportSource(mine.camera, name=name), "lensfun")
    models = [e.text for e in ET.fromstring(file.content).iter("model")]
    assert models == ["".join(c for c in name if c.isprintable() and c != "\ufffe") or "camera"] * 2


def test_calibration_without_keypoints_is_converted_too() -> None:
    mine = subject("rectilinear")
    bare = ExportSource(mine.camera, name=mine.name)
    for name in formats.FORMAT_NAMES:
        if name == "corners-vnl":
            with pytest.raises(CalibrationError, match="no keypoints"):
                formats.write(bare, name)
        else:
            assert formats.write(bare, name).error < 0.02 * IMG_SIZE[0] or name == "gltf"


def test_unsuitable_format_is_refused() -> None:
    with pytest.raises(CalibrationError, match="off by more than the image is wide") as caught:
        formats.write(subject("fisheye"), "artoolkit")
    assert caught.value.code == "not_representable"
    with pytest.raises(CalibrationError, match="no format is called"):
        formats.write(subject("fisheye"), "visicalc")
