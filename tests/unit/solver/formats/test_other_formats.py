"""mrcal, Lensfun, DNG, ARToolKit, WebXR and glTF: what they, or their arithmetic, make of our files."""

import ast
import json
import math
import struct

import cv2
import lensfunpy
import numpy as np
import pytest

from calibsolver import Camera, formats, image_transform, models
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import lensfun as lensfun_format
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.grid import grid
from calibsolver.formats.reading import read_bytes
from tests.helpers.node import run_module
from tests.helpers.solver.export_sources import IMG_SIZE, image_rays, subject, written
from tests.unit.solver.formats.test_conversion_error import inputs

W, H = IMG_SIZE


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
    seen = arrays["observations_board"]
    assert seen.shape == (len(mine.views), 5, 8, 3)
    assert int((seen[..., 2] > 0).sum()) == sum(len(view) for view in mine.views)
    # the poses are those of the corner grid, whose origin is its first corner
    rt, k, d = arrays["frames_rt_toref"][0], data["intrinsics"][:4], data["intrinsics"][4:]
    column, row = np.meshgrid(np.arange(8.0), np.arange(5.0))
    points = np.stack([column, row, np.zeros_like(row)], axis=2).reshape(-1, 3)
    matrix = np.array([[k[0], 0, k[2]], [0, k[1], k[3]], [0, 0, 1]])
    q = cv2.projectPoints(points, rt[:3], rt[3:], matrix, np.array(d))[0].reshape(-1, 2)
    good = seen[0, ..., 2].ravel() > 0
    away = np.linalg.norm(q - seen[0, ..., :2].reshape(-1, 2), axis=1)[good]
    assert np.sqrt(np.mean(away**2)) < 1.5 * mine.rms


def test_corners_table_has_a_line_for_every_corner_of_every_view() -> None:
    mine = subject("fisheye")
    lines = formats.write(mine, "corners-vnl").content.decode().splitlines()
    assert "# filename x y level" in lines
    rows = [line.split() for line in lines if not line.startswith("#")]
    assert len(rows) == 40 * len(mine.views)
    assert len({row[0] for row in rows}) == len(mine.views)
    assert sum(row[1] == "-" for row in rows) == 40 * len(mine.views) - sum(len(v) for v in mine.views)


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
    ours = warped(content, np.stack([x.ravel(), y.ravel()], axis=1).astype(float))
    theirs = np.stack([maps[0][y, x].ravel(), maps[1][y, x].ravel()], axis=1)
    assert np.abs(ours - theirs).max() < 1e-3


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


@pytest.mark.parametrize("model", models.NAMES)
def test_webxr_matrix_is_column_major(model: str) -> None:
    camera = subject(model).camera
    data = json.loads(written(model, "webxr").content)
    assert np.array_equal(np.array(data["cameraMatrix"]).reshape(3, 3).T, camera.matrix)
    assert data["distortionCoefficients"] == camera.distortion.tolist()
    assert data["distortionModel"] == model


def test_gltf_states_its_omissions() -> None:
    file, camera = written("rectilinear", "gltf"), subject("rectilinear").camera
    data = json.loads(file.content)
    lens = data["cameras"][data["nodes"][data["scenes"][data["scene"]]["nodes"][0]]["camera"]]
    assert lens["extras"]["camera_matrix"] == camera.matrix.tolist()
    assert lens["extras"]["distortion_coefficients"] == camera.distortion.tolist()
    assert file.error > 1
    assert f"{file.error:.2f}" in lens["extras"]["warning"]


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
const { files, points } = JSON.parse(readFileSync(0, 'utf8'));
const at = ([x, y, z]) => new Vector3(x, -y, -z);
const seen = (camera) => points.map((p) => at(p).project(camera).toArray().slice(0, 2));
console.log(JSON.stringify(files.map(({ webxr, gltf }) => {
  const ours = new PerspectiveCamera();
  ours.projectionMatrix = new Matrix4().fromArray(webxr.projectionMatrix);
  ours.projectionMatrixInverse = ours.projectionMatrix.clone().invert();
  ours.updateMatrixWorld();
  // what three's GLTFLoader does with a perspective camera
  const { yfov, aspectRatio, znear, zfar } = gltf.cameras[0].perspective;
  const loaded = new PerspectiveCamera(yfov * 180 / Math.PI, aspectRatio, znear, zfar);
  loaded.updateMatrixWorld();
  return { webxr: seen(ours), gltf: seen(loaded) };
})));
"""
POINTS = np.random.default_rng(2).uniform((-0.5, -0.3, 1), (0.5, 0.3, 5), (40, 3))


@pytest.fixture(scope="module")
def drawn() -> dict[str, dict[str, list[list[float]]]]:
    """Pixels at which three.js draws the points with the files of each model."""
    files = [
        {name: json.loads(written(model, name).content) for name in ("webxr", "gltf")}
        for model in models.NAMES
    ]
    found = run_module(THREE, sent={"files": files, "points": POINTS.tolist()})
    return dict(zip(models.NAMES, found, strict=True))


@pytest.mark.parametrize("model", models.NAMES)
def test_points_are_projected_as_by_the_pinhole(
    model: str, drawn: dict[str, dict[str, list[list[float]]]]
) -> None:
    camera, (w, h) = subject(model).camera, IMG_SIZE
    said = {
        name: np.stack([(q[:, 0] + 1) / 2 * w - 0.5, (1 - q[:, 1]) / 2 * h - 0.5], axis=1)
        for name, q in ((name, np.array(q)) for name, q in drawn[model].items())
    }
    k = np.array(camera.matrix)
    for name, centre in (("webxr", k[:2, 2]), ("gltf", np.array([w - 1, h - 1]) / 2)):
        pinhole = POINTS[:, :2] / POINTS[:, 2:] * (k[0, 0], k[1, 1]) + centre
        assert np.abs(said[name] - pinhole).max() < 1e-9 * w, name
