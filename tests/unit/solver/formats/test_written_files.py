"""Written files, read by the tools they are for, or by what those document and compute."""

import ast
import json
import math
import struct
import xml.etree.ElementTree as ET
from collections.abc import Callable

import cv2
import lensfunpy
import numpy as np
import pycolmap
import pytest
import yaml

from calibsolver import CalibrationError, Camera, formats, image_transform, models
from calibsolver.arrays import Array
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportedFile, ExportSource
from calibsolver.formats import lensfun as lensfun_format
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.grid import grid
from calibsolver.formats.reading import read_bytes
from tests.helpers.node import run_module
from tests.helpers.solver.export_sources import IMG_SIZE, image_rays, subject, written
from tests.unit.solver.formats.test_conversion_error import inputs

W, H = IMG_SIZE
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


@pytest.mark.parametrize(("keypoints", "most"), [(True, 5), (False, 1)])
def test_perspective_model_of_a_wide_lens_fits_to_80_degrees(keypoints: bool, most: float) -> None:
    mine = subject("fisheye")
    file = formats.write(mine if keypoints else ExportSource(mine.camera), "photonvision")
    assert 0.8 < file.coverage < 1
    assert file.error < most
    assert f"holds {100 * file.coverage:.0f} % of the image" in str(file.warning)
    data = json.loads(file.content)
    k, d = np.array(data["cameraIntrinsics"]["data"]).reshape(3, 3), np.array(data["distCoeffs"]["data"])
    off("fisheye", file, opencv(k, d))


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


# ---- mrcal


@pytest.mark.parametrize("model", models.NAMES)
def test_mrcal_model_has_every_member_of_the_reader(model: str) -> None:
    file, mine = written(model, "mrcal"), subject(model)
    data = ast.literal_eval(file.content.decode())
    sizes = {"LENSMODEL_OPENCV5": 5, "LENSMODEL_OPENCV8": 8}
    assert len(data["intrinsics"]) == 4 + sizes[data["lensmodel"]]
    assert data["imagersize"] == [W, H]
    assert data["extrinsics"] == data["rt_cam_ref"] == [0] * 6
    assert data["icam_intrinsics"] == 0
    arrays = inputs(file)
    assert arrays["observations_board"].shape == (len(mine.views), 5, 8, 3)


def test_measurements_stay_with_a_turned_and_mirrored_picture() -> None:
    mine = subject("rectilinear")
    turned = image_transform.rotate(IMG_SIZE, 90).then(image_transform.mirror((H, W)))
    for name in ("mrcal", "corners-vnl", "photonvision"):
        file = formats.write(mine, name, turned)
        found = read_bytes(file.content, options=ReaderOptions(squares=(9, 6)))
        assert grid(found.views).squares == (9, 6)
        assert sum(len(view) for view in found.views) == sum(len(view) for view in mine.views)
        rms = reprojection_score(turned.camera(mine.camera), found.views).rms
        assert rms == pytest.approx(mine.rms, rel=1e-6)


# ---- Lensfun


@pytest.mark.parametrize("model", models.NAMES)
def test_lensfun_maps_the_corrected_picture_to_ours(model: str) -> None:
    file, camera = written(model, "lensfun"), subject(model).camera
    database = lensfunpy.Database(xml=file.content.decode(), load_common=False, load_bundled=False)
    (body,) = database.find_cameras("calibDB", subject(model).name, loose_search=True)
    (lens,) = database.find_lenses(body, "calibDB", subject(model).name, loose_search=True)
    modifier = lensfunpy.Modifier(lens, body.crop_factor, W, H)
    modifier.initialize(lens.min_focal, 8, 10, pixel_format=np.uint8, flags=lensfunpy.ModifyFlags.DISTORTION)
    source = modifier.apply_geometry_distortion().astype(np.float64)
    # The corrected picture is a pinhole's (a fisheye's: equidistant), of a focal length s times as large.
    radial = formats.FORMATS["lensfun"].convert(subject(model)).camera
    s, f = lensfun_format.polynomial(radial)[3], radial.matrix[0, 0]
    x, y = np.meshgrid(np.arange(0, W, 40), np.arange(0, H, 40))
    d = (np.stack([x.ravel(), y.ravel()], axis=1) - radial.matrix[:2, 2]) / (s * f)
    r = np.linalg.norm(d, axis=1)
    if radial.model == "fisheye":
        rays = np.column_stack([d * np.sinc(r / np.pi)[:, None], np.cos(r)])
    else:
        rays = np.column_stack([d, np.ones(len(d))])
    q = camera.project(rays)
    there = source[y, x].reshape(-1, 2)
    inside = np.isfinite(q).all(axis=1) & (q >= 0).all(axis=1) & (q <= (W - 1, H - 1)).all(axis=1)
    away = np.linalg.norm(q[inside] - there[inside], axis=1)
    # Lensfun's own arithmetic is single precision with an approximate square root: 0.1 px
    assert away.max() < file.error + 0.15


# ---- DNG


def opcode(content: bytes) -> tuple[int, list[float], float, float]:
    """Number, coefficients and centre of the one opcode, by the specification's layout."""
    count, number, version, flags, size = struct.unpack_from(">5I", content)
    assert (count, version, flags) == (1, 0x01030000, 1)
    assert len(content) == 20 + size
    (planes,) = struct.unpack_from(">I", content, 20)
    assert planes == 1
    *values, cx, cy = struct.unpack_from(f">{(size - 4) // 8}d", content, 24)
    return number, values, cx, cy


def warped(content: bytes, q: np.ndarray) -> np.ndarray:
    """Source pixels of corrected pixels (n, 2): the arithmetic of chapter 7 of the specification."""
    number, v, cx, cy = opcode(content)
    centre = np.array([cx * W, cy * H])
    m = math.hypot(max(centre[0], W - centre[0]), max(centre[1], H - centre[1]))
    d = (q - centre) / m
    r = np.linalg.norm(d, axis=1)
    if number == 1:
        ratio = v[0] + v[1] * r**2 + v[2] * r**4 + v[3] * r**6
        x, y = d.T
        tangential = np.stack(
            [v[4] * 2 * x * y + v[5] * (r**2 + 2 * x * x), v[5] * 2 * x * y + v[4] * (r**2 + 2 * y * y)],
            axis=1,
        )
        return centre + m * (d * ratio[:, None] + tangential)
    t = np.arctan(r)
    ratio = (v[0] * t + v[1] * t**3 + v[2] * t**5 + v[3] * t**7) / np.maximum(r, 1e-12)
    return centre + m * d * ratio[:, None]


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_dng_opcode_equals_opencvs_undistortion(model: str) -> None:
    mine = subject(model)
    held = formats.FORMATS["dng"].convert(mine)
    content = formats.FORMATS["dng"].write(mine, held)
    k, d = np.array(held.camera.matrix), np.array(held.camera.distortion)
    assert k[0, 0] == k[1, 1]
    number, values, *_ = opcode(content)
    new = k.copy()
    if model == "fisheye":
        assert number == 2
        new[0, 0] = new[1, 1] = math.hypot(max(k[0, 2], W - k[0, 2]), max(k[1, 2], H - k[1, 2]))
        maps = cv2.fisheye.initUndistortRectifyMap(k, d, np.eye(3), new, IMG_SIZE, cv2.CV_32FC1)
    else:
        assert (number, values[0]) == (1, 1.0)
        maps = cv2.initUndistortRectifyMap(k, d, np.eye(3), new, IMG_SIZE, cv2.CV_32FC1)
    x, y = np.meshgrid(np.arange(0, W, 16), np.arange(0, H, 16))
    corrected = np.stack([x.ravel(), y.ravel()], axis=1).astype(float)
    ours = warped(content, corrected)
    theirs = np.stack([maps[0][y, x].ravel(), maps[1][y, x].ravel()], axis=1)
    assert np.abs(ours - theirs).max() < 1e-3
    rays = np.column_stack([(corrected - new[:2, 2]) / new[0, 0], np.ones(len(corrected))])
    q = mine.camera.project(rays)
    inside = ((q >= 0) & (q <= (W - 1, H - 1))).all(axis=1)
    away = np.linalg.norm(q - ours, axis=1)[inside].max()
    assert 0.5 * held.error < away <= held.error + 1e-3


def test_dng_fisheye_refits_four_terms() -> None:
    camera = Camera(
        "fisheye", [[700, 0, 640], [0, 700, 360], [0, 0, 1]], [-0.03, 0.02, -0.02, 0.006], IMG_SIZE
    )
    bare = formats.ExportSource(camera)
    held = formats.FORMATS["dng"].convert(bare)
    assert held.error < 0.01
    cut = Camera("fisheye", camera.matrix, [*camera.distortion[:3], 0.0], IMG_SIZE)
    angle = np.array([[np.sin(0.75), 0, np.cos(0.75)]])
    assert abs(cut.project(angle) - camera.project(angle)).max() > 10 * held.error


# ---- AR.js


def test_camera_para_is_read_by_artoolkits_own_arithmetic() -> None:
    mine = subject("rectilinear")
    file = formats.write(mine, "artoolkit")
    assert len(file.content) == 176, "the length says the version"
    w, h, *rest = struct.unpack(">2i12d9d", file.content)
    matrix = np.array(rest[:12]).reshape(3, 4)
    k1, k2, p1, p2, fx, fy, x0, y0, s = rest[12:]
    assert (w, h, s) == (W, H, 1.0)
    rays, q = image_rays(mine.camera)
    assert matrix.tolist() == [[fx, 0, x0, 0], [0, fy, y0, 0], [0, 0, 1, 0]]
    # arParamIdeal2Observ of version 4 is then OpenCV's formula.
    distorted = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix[:, :3], np.array([k1, k2, p1, p2]))
    assert np.linalg.norm(distorted[0][:, 0] - q, axis=1).max() <= file.error + 0.01


# ---- pages


def test_files_of_pages_have_the_matrix_and_the_distortion() -> None:
    """WebXR's matrices are column-major; glTF holds what it omits in `extras`."""
    camera = subject("rectilinear").camera
    webxr, gltf = (json.loads(written("rectilinear", name).content) for name in ("webxr", "gltf"))
    assert np.array_equal(np.array(webxr["cameraMatrix"]).reshape(3, 3).T, camera.matrix)
    assert webxr["distortionCoefficients"] == camera.distortion.tolist()
    lens = gltf["cameras"][gltf["nodes"][gltf["scenes"][gltf["scene"]]["nodes"][0]]["camera"]]
    assert lens["extras"]["camera_matrix"] == camera.matrix.tolist()
    assert lens["extras"]["distortion_coefficients"] == camera.distortion.tolist()


ARTOOLKIT = """
import artoolkit from "@ar-js-org/artoolkit5-js";
import { readFileSync } from "node:fs";
console.log = () => {};
const { file, width, height } = JSON.parse(readFileSync(0, "utf8"));
const control = await artoolkit.ARController.initWithDimensions(width, height, Uint8Array.from(file));
process.stdout.write(`\\n${JSON.stringify([...control.getCameraMatrix()])}`);
process.exit(0); // it keeps a timer
"""


def test_artoolkit_draws_as_the_camera_that_was_written() -> None:
    """But for its own matrix, which takes the picture to be a pixel smaller than it is."""
    written = formats.write(subject("rectilinear"), "artoolkit")
    matrix = run_module(ARTOOLKIT, sent={"file": list(written.content), "width": W, "height": H})
    ours = np.frombuffer(written.content, ">f8", 12, offset=8).reshape(3, 4)[:, :3]
    rng = np.random.default_rng(2)
    rays = np.column_stack([rng.uniform(-0.6, 0.6, 200), rng.uniform(-0.35, 0.35, 200), np.ones(200)])
    pinhole = (rays @ ours.T)[:, :2] + 0.5  # px from the picture's corner
    drawn = np.column_stack([rays * (1, -1, -1), np.ones(200)]) @ np.array(matrix).reshape(4, 4)
    ndc = drawn[:, :2] / drawn[:, 3:]
    off = np.linalg.norm((ndc * (1, -1) + 1) / 2 * IMG_SIZE - pinhole, axis=1)
    assert off.max() < 1
    assert off.max() > 0.2, "or `applyCalibration` would not be needed beside it"


THREE = """
import { readFileSync } from 'node:fs';
import { Matrix4, PerspectiveCamera, Vector3 } from 'three';
const { webxr, gltf, points } = JSON.parse(readFileSync(0, 'utf8'));
const at = ([x, y, z]) => new Vector3(x, -y, -z);
const seen = (camera) => points.map((p) => at(p).project(camera).toArray().slice(0, 2));
const ours = new PerspectiveCamera();
ours.projectionMatrix = new Matrix4().fromArray(webxr.projectionMatrix);
ours.projectionMatrixInverse = ours.projectionMatrix.clone().invert();
ours.updateMatrixWorld();
// what three's GLTFLoader does with a perspective camera
const { yfov, aspectRatio, znear, zfar } = gltf.cameras[0].perspective;
const loaded = new PerspectiveCamera(yfov * 180 / Math.PI, aspectRatio, znear, zfar);
loaded.updateMatrixWorld();
console.log(JSON.stringify({ webxr: seen(ours), gltf: seen(loaded) }));
"""


def test_three_projects_points_as_the_pinhole() -> None:
    points = np.random.default_rng(2).uniform((-0.5, -0.3, 1), (0.5, 0.3, 5), (40, 3))
    files = {name: json.loads(written("rectilinear", name).content) for name in ("webxr", "gltf")}
    drawn = run_module(THREE, sent={**files, "points": points.tolist()})
    k = subject("rectilinear").camera.matrix
    for name, centre in (("webxr", k[:2, 2]), ("gltf", np.array([W - 1, H - 1]) / 2)):
        q = (np.array(drawn[name]) * (1, -1) + 1) / 2 * IMG_SIZE - 0.5
        pinhole = points[:, :2] / points[:, 2:] * (k[0, 0], k[1, 1]) + centre
        assert np.abs(q - pinhole).max() < 1e-9 * W, name
