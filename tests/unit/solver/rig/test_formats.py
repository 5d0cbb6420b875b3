"""Files of rigs: the tools that read them project points where the rig sees them.

The tools are OpenCV and pycolmap. Of ROS and Kalibr: the rules of their readers.
"""

import io
import json
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pycolmap
import pytest
import yaml

from calibsolver import CalibrationError, Camera
from calibsolver.arrays import Array
from calibsolver.rig import formats
from calibsolver.rig.formats import RigSource
from calibsolver.rig.rectification import rectify
from calibsolver.rig.start import RigidMotion
from tests.helpers.solver import rigs
from tests.helpers.solver.export_sources import IMG_SIZE as SIZE
from tests.helpers.solver.export_sources import truth

THREE = ("rectilinear", "fisheye", "rational")
STEPS: dict[str, Any] = {
    "beside": rigs.placed((0.12, 0.004, 0.002), (0.01, -0.03, 0.02)),
    "above": rigs.placed((0.003, 0.15, -0.004), (0.02, 0.01, -0.02)),
}
"""Motions camera 0 -> camera 1, metres."""
POINTS = np.array(
    [[x, y, z] for z in (0.8, 1.5, 4.0) for x in (-0.25, 0.0, 0.2) for y in (-0.15, 0.03, 0.18)]
)
"""(n, 3), frame of camera 0, metres; all cameras see them."""


def camera(model: str) -> Camera:
    whole = truth(model)
    if model != "rectilinear":
        return whole
    return Camera(model, whole.matrix, [*whole.distortion[:4], 0.0], SIZE)  # Kalibr and COLMAP hold four


def source(models: Sequence[str] = ("rectilinear", "rectilinear"), step: str = "beside") -> RigSource:
    """Rig of cameras, each one step from the one before."""
    motions = [RigidMotion(np.eye(3), np.zeros(3))]
    for _ in models[1:]:
        motions.append(STEPS[step] @ motions[-1])
    return RigSource([camera(model) for model in models], np.array([m.vector() for m in motions]), "metres")


def unpacked(rig: RigSource, name: str) -> dict[str, bytes]:
    """Files of the archive that a rig is written to."""
    with zipfile.ZipFile(io.BytesIO(formats.write(rig, name).content)) as archive:
        return {member: archive.read(member) for member in archive.namelist()}


def chain_of(rig: RigSource) -> dict[str, Any]:
    chain: dict[str, Any] = yaml.safe_load(formats.write(rig, "kalibr").content)
    return chain


def seen(rig: RigSource, position: int) -> Array:
    """Pixels (n, 2) of the points."""
    found = rig.cameras[position].project(rig.motion(position)(POINTS))
    assert np.isfinite(found).all()
    return found


def rectified(q: Array, read: dict[str, Any], side: int) -> Array:
    """Pixels of a rectified picture, by what a stereo YAML says and the function that OpenCV has for it."""
    k, d, r, p = (read[f"{name}{side}"] for name in "KDRP")
    points = np.ascontiguousarray(q[:, None])
    if read[f"xi{side}"] is not None:
        flat = cv2.omnidir.undistortPoints(points, k, d, read[f"xi{side}"], r)
        return np.asarray(flat.reshape(-1, 2) @ p[:2, :2].T + p[:2, 2])
    undistort = cv2.fisheye.undistortPoints if read[f"fisheye{side}"] else cv2.undistortPoints
    return np.asarray(undistort(points, k, d, R=r, P=p).reshape(-1, 2))


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize(
    "models", [("rectilinear", "fisheye"), ("fisheye", "rational"), ("rational", "omnidirectional")]
)
def test_opencv_rectifies_and_measures_pairs_of_mixed_models(
    models: tuple[str, str], step: str, tmp_path: Path
) -> None:
    rig = source(models, step)
    path = tmp_path / "stereo.yml"
    path.write_bytes(formats.write(rig, "opencv-yaml").content)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    names = [f"{name}{side}" for name in ("K", "D", "R", "P", "xi") for side in (1, 2)]
    read: dict[str, Any] = {name: storage.getNode(name).mat() for name in [*names, "R", "T", "E", "F", "Q"]}
    read |= {
        f"fisheye{s}": storage.getNode(n).real() for s, n in ((1, "fisheye_model"), (2, "fisheye_model2"))
    }
    storage.release()
    assert [bool(read[f"fisheye{side}"]) for side in (1, 2)] == [model == "fisheye" for model in models]
    motion = rig.motion(1)
    assert read["K1"].tolist() == rig.cameras[0].matrix.tolist()
    assert read["R"] == pytest.approx(motion.r)
    assert read["T"].ravel() == pytest.approx(motion.t)
    assert (motion(POINTS) @ read["E"] * POINTS).sum(axis=1) == pytest.approx(0, abs=1e-7)
    one, other = (rectified(seen(rig, side - 1), read, side) for side in (1, 2))
    across = 0 if step == "above" else 1
    assert np.abs(one[:, across] - other[:, across]).max() < 0.01
    disparity = (one - other)[:, 1 - across]
    back = np.column_stack([one, disparity, np.ones(len(one))]) @ read["Q"].T
    assert (back[:, :3] / back[:, 3:]) @ read["R1"] == pytest.approx(POINTS, rel=2e-3, abs=2e-3)
    # F joins pixels without distortion
    pinhole = [rig.motion(i)(POINTS) @ read[f"K{i + 1}"].T for i in (0, 1)]
    one, other = (p / p[:, 2:] for p in pinhole)
    lines = one @ read["F"].T
    assert np.abs((lines * other).sum(axis=1) / np.hypot(lines[:, 0], lines[:, 1])).max() < 1e-6


@pytest.mark.parametrize("models", [("rectilinear", "rational"), ("fisheye", "rectilinear")])
def test_a_stereo_pair_of_ros_measures_depth(models: tuple[str, str]) -> None:
    """By the rules of image_geometry: rectifyPoint, and StereoCameraModel's requirements and disparity."""
    rig = source(models)
    files = unpacked(rig, "ros")
    assert list(files) == ["left.yaml", "right.yaml"]
    places, rotations, projections = [], [], []
    for i, content in enumerate(files.values()):
        info = yaml.safe_load(content)
        k, r, p = (
            np.reshape(info[f"{name}_matrix"]["data"], (3, -1))
            for name in ("camera", "rectification", "projection")
        )
        d = np.array(info["distortion_coefficients"]["data"])
        is_fisheye = info["distortion_model"] == "equidistant"
        undistort = cv2.fisheye.undistortPoints if is_fisheye else cv2.undistortPoints
        points = np.ascontiguousarray(seen(rig, i)[:, None])
        places.append(undistort(points, k, d, R=r, P=p).reshape(-1, 2))
        rotations.append(r)
        projections.append(p)
        assert r @ r.T == pytest.approx(np.eye(3))
    left, right = projections
    assert np.array_equal(left[:, :3], right[:, :3])
    assert not left[:, 3].any()
    baseline = -right[0, 3] / right[0, 0]
    assert baseline == pytest.approx(np.linalg.norm(rig.motion(1).t))
    assert np.abs(places[0][:, 1] - places[1][:, 1]).max() < 0.01
    depth = left[0, 0] * baseline / (places[0] - places[1])[:, 0]
    assert depth == pytest.approx(POINTS @ rotations[0][2], rel=2e-3)


def test_ros_has_a_file_for_each_of_more_cameras() -> None:
    files = unpacked(source(THREE), "ros")
    assert set(files) == {"cam0.yaml", "cam1.yaml", "cam2.yaml"}
    for content in files.values():
        assert yaml.safe_load(content)["rectification_matrix"]["data"] == np.eye(3).ravel().tolist()


def test_a_camchain_of_kalibr_leads_to_every_camera() -> None:
    """By the rules of Kalibr's CameraChainParameters and aslam_cv's cameras."""
    rig = source(("fisheye", "rectilinear", "omnidirectional"))
    chain = chain_of(rig)
    assert "T_cn_cnm1" not in chain["cam0"]
    there = np.eye(4)
    for i, (name, cam) in enumerate(chain.items()):
        assert name == f"cam{i}"
        assert cam["rostopic"] == f"/cam{i}/image_raw"
        if i:
            step = np.array(cam["T_cn_cnm1"])
            assert step.shape == (4, 4)
            assert step[3].tolist() == [0, 0, 0, 1]
            assert step[:3, :3] @ step[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
            there = step @ there
        *xi, fu, fv, pu, pv = cam["intrinsics"]
        k, d = np.array([[fu, 0, pu], [0, fv, pv], [0, 0, 1]]), np.array(cam["distortion_coeffs"])
        points = POINTS @ there[:3, :3].T + there[:3, 3]
        if cam["camera_model"] == "omni":
            found = Camera("omnidirectional", k, np.array([*xi, *d]), SIZE).project(points)
        elif cam["distortion_model"] == "equidistant":
            found = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), k, d)[0]
        else:
            found = cv2.projectPoints(points, np.zeros(3), np.zeros(3), k, d)[0]
        assert np.abs(found.reshape(-1, 2) - seen(rig, i)).max() < 1e-6, name


def test_pycolmap_projects_into_every_camera_of_the_rig(tmp_path: Path) -> None:
    rig = source(THREE)
    for name, content in unpacked(rig, "colmap").items():
        (tmp_path / name).write_bytes(content)
    for name in ("images.txt", "points3D.txt", "rigs.txt", "frames.txt"):
        (tmp_path / name).write_text("")
    model = pycolmap.Reconstruction()
    model.read_text(tmp_path)
    (config,) = pycolmap.read_rig_config(tmp_path / "rig_config.json")
    assert len(model.cameras) == len(config.cameras) == 3
    for i, sensor in enumerate(config.cameras):
        points = POINTS if sensor.ref_sensor else np.array([sensor.cam_from_rig * p for p in POINTS])
        for read in (model.cameras[i + 1], sensor.camera):
            assert (read.width, read.height) == SIZE or read is sensor.camera  # which the images say
            found = np.array([read.img_from_cam(p) for p in points]) - 0.5
            assert np.abs(found - seen(rig, i)).max() < 1e-6


def test_nodes_of_gltf_look_where_the_cameras_do() -> None:
    rig = source(THREE)
    scene = json.loads(formats.write(rig, "gltf").content)
    flip = np.diag([1.0, -1.0, -1.0])
    assert scene["scenes"][0]["nodes"] == [0, 1, 2]
    for i, node in enumerate(scene["nodes"]):
        assert node["camera"] == i
        x, y, z, w = node["rotation"]
        # glTF 2.0, 3.5: a unit quaternion, x y z w; a node's points are turned, then shifted
        assert np.linalg.norm([x, y, z, w]) == pytest.approx(1)
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        r = np.eye(3) + 2 * w * k + 2 * k @ k
        local = (POINTS @ flip - node["translation"]) @ r
        assert local @ flip == pytest.approx(rig.motion(i)(POINTS))


def test_rectification_is_opencvs() -> None:
    """Rotations equal cv2.stereoRectify's; sizes of the pictures are a matter of choice."""
    rig = source()
    one, other = rig.cameras
    motion = rig.motion(1)
    found = rectify(one, other, motion)
    lenses = one.matrix, one.distortion, other.matrix, other.distortion
    r1, r2, *_ = cv2.stereoRectify(*lenses, one.img_size, motion.r, motion.t[:, None])
    assert found.r1 == pytest.approx(r1, abs=1e-12)
    assert found.r2 == pytest.approx(r2, abs=1e-12)


def test_label_of_a_camera_is_no_member_of_a_file() -> None:
    """Labels are strangers' words: none takes a part of a file away, or stands for one."""
    labels = [
        "x rectification_matrix: y",
        "cam0: [ 0, 0, 0, 0, 0, 0,] } /cam0/",
        "a\nimage_width: 7 # {a} %s",
    ]
    plain = source()
    for label in labels:
        named = replace(plain, names=[label] * 2)
        for one, other in zip(unpacked(named, "ros").values(), unpacked(plain, "ros").values(), strict=True):
            assert {**yaml.safe_load(one), "camera_name": ""} == {**yaml.safe_load(other), "camera_name": ""}
        assert chain_of(named) == chain_of(plain)
        for one, other in zip(
            unpacked(named, "mrcal").values(), unpacked(plain, "mrcal").values(), strict=True
        ):
            assert eval(one, {}) == eval(other, {})


def test_mrcal_models_have_their_poses() -> None:
    rig = source()
    first, second = (eval(content, {}) for content in unpacked(rig, "mrcal").values())
    assert first["rt_cam_ref"] == [0] * 6
    assert second["rt_cam_ref"] == pytest.approx(rig.poses[1])


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(CalibrationError, match="opencv-yaml"):
        formats.write(source(), "stl")


def test_cameras_in_one_place_have_no_rectification() -> None:
    rig = replace(source(), poses=source().poses * [1, 1, 1, 0, 0, 0])
    content = formats.write(rig, "opencv-yaml").content.decode()
    assert "R: !!opencv-matrix" in content
    assert "R1:" not in content
