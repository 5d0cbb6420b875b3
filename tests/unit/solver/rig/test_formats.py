"""Files of rigs, read back by the tools that they are for."""

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pycolmap
import pytest
import yaml

from calibsolver import CalibrationError, Camera
from calibsolver.formats import kalibr
from calibsolver.rig import formats
from calibsolver.rig.formats import RigSource
from calibsolver.rig.rectification import rectify
from tests.helpers.solver import rigs, synthetic


def source(count: int = 2, kind: str = "rectilinear") -> RigSource:
    """Rig side by side, in metres."""
    of = synthetic.rectilinear_cameras if kind == "rectilinear" else synthetic.fisheye_cameras
    rig = rigs.side_by_side(of(count), 0.12)
    return RigSource(rig.cameras, np.array([m.vector() for m in rig.motions]), "metres")


def unpack(content: bytes) -> dict[str, bytes]:
    """Members of an archive."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_opencv_reads_the_stereo_file(kind: str, tmp_path: Path) -> None:
    rig = source(kind=kind)
    written = formats.write(rig, "opencv-yaml")
    path = tmp_path / written.filename
    path.write_bytes(written.content)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    m: dict[str, Any] = {
        key: storage.getNode(key).mat()
        for key in ("K1", "D1", "K2", "D2", "R", "T", "E", "F", "R1", "R2", "P1", "P2", "Q")
    }
    storage.release()
    motion, (one, other) = rig.motion(1), rig.cameras
    assert m["K1"].tolist() == one.matrix.tolist()
    assert m["D2"].ravel().tolist() == other.distortion.tolist()
    assert m["R"] == pytest.approx(motion.r)
    assert m["T"].ravel() == pytest.approx(motion.t)
    # a point seen by both is on the epipolar line, and in one row once rectified
    point = np.array([[0.1, -0.05, 1.2]])
    rays = [camera.project(p)[0] for camera, p in ((one, point), (other, motion(point)))]
    undistort = cv2.fisheye.undistortPoints if kind == "fisheye" else cv2.undistortPoints
    flat = [undistort(q.reshape(1, 1, 2), m[f"K{i}"], m[f"D{i}"]).ravel() for i, q in enumerate(rays, 1)]
    assert np.append(flat[1], 1) @ m["E"] @ np.append(flat[0], 1) == pytest.approx(0, abs=1e-7)
    rows = [
        undistort(q.reshape(1, 1, 2), m[f"K{i}"], m[f"D{i}"], R=m[f"R{i}"], P=m[f"P{i}"]).ravel()
        for i, q in enumerate(rays, 1)
    ]
    assert rows[0][1] == pytest.approx(rows[1][1], abs=1e-3)
    back = m["Q"] @ [*rows[0], rows[0][0] - rows[1][0], 1]
    assert m["R1"] @ point[0] == pytest.approx(back[:3] / back[3], abs=1e-4)


def test_rectification_is_opencvs() -> None:
    """Rotations equal cv2.stereoRectify's; sizes of the pictures are a matter of choice."""
    rig = source()
    one, other = rig.cameras
    motion = rig.motion(1)
    found = rectify(one, other, motion)
    r1, r2, *_ = cv2.stereoRectify(
        one.matrix, one.distortion, other.matrix, other.distortion, one.img_size, motion.r, motion.t[:, None]
    )
    assert found.r1 == pytest.approx(r1, abs=1e-12)
    assert found.r2 == pytest.approx(r2, abs=1e-12)


def test_ros_has_the_projection_of_a_stereo_pair() -> None:
    rig = source()
    files = unpack(formats.write(rig, "ros").content)
    left, right = (yaml.safe_load(files[f"{side}.yaml"]) for side in ("left", "right"))
    p = np.reshape(right["projection_matrix"]["data"], (3, 4))
    assert p[0, 3] / p[0, 0] == pytest.approx(-np.linalg.norm(rig.motion(1).t)), "-baseline"
    assert left["projection_matrix"]["data"][3] == 0
    for each in (left, right):
        r = np.reshape(each["rectification_matrix"]["data"], (3, 3))
        assert r @ r.T == pytest.approx(np.eye(3))


def test_label_of_a_camera_is_no_member_of_a_file() -> None:
    """Labels are strangers' words: none takes a part of a file away, or stands for one."""
    labels = [
        "x rectification_matrix: y",
        "cam0: [ 0, 0, 0, 0, 0, 0,] } /cam0/",
        "a\nimage_width: 7 # {a} %s",
    ]
    for label in labels:
        named = replace(source(), names=[label] * 2)
        for name, content in unpack(formats.write(named, "ros").content).items():
            plain = yaml.safe_load(unpack(formats.write(source(), "ros").content)[name])
            assert yaml.safe_load(content) | {"camera_name": ""} == plain | {"camera_name": ""}
        chains = [yaml.safe_load(formats.write(rig, "kalibr").content) for rig in (named, source())]
        assert chains[0] == chains[1]
        for name, content in unpack(formats.write(named, "mrcal").content).items():
            plain = eval(unpack(formats.write(source(), "mrcal").content)[name], {})
            assert eval(content, {}) == plain


def test_kalibr_chains_each_camera_to_the_one_before() -> None:
    rig = source(3, "fisheye")
    chain = yaml.safe_load(formats.write(rig, "kalibr").content)
    assert list(chain) == ["cam0", "cam1", "cam2"]
    total = np.eye(4)
    for i in (1, 2):
        total = np.array(chain[f"cam{i}"]["T_cn_cnm1"]) @ total
        assert total[:3, :3] == pytest.approx(rig.motion(i).r)
        assert total[:3, 3] == pytest.approx(rig.motion(i).t)


def test_kalibr_file_of_eight_cameras_that_it_cannot_hold_turns_none() -> None:
    lens = [-0.28, 0.09, 0.001, -0.0005, -0.01]
    matrix = np.array([[600.0, 0, 650], [0, 602, 370], [0, 0, 1]])
    camera = Camera("rectilinear", matrix, np.array(lens), (1280, 720))
    rig = RigSource([camera] * 8, np.zeros((8, 6)))
    written = formats.write(rig, "kalibr")
    held = kalibr.read(yaml.safe_load(written.content)["cam7"]).camera
    assert held is not None
    # A fit of keypoints was 2.7 px off on average, 10.6 px in a corner.
    q = np.stack(np.meshgrid(np.linspace(0, 1279, 33), np.linspace(0, 719, 25)), axis=2).reshape(-1, 2)
    away = held.project(camera.unproject(q)) - q
    assert np.linalg.norm(away.mean(axis=0)) < 0.3
    assert np.linalg.norm(away, axis=1).max() <= written.error < 6


def test_colmap_reads_cameras_and_rig(tmp_path: Path) -> None:
    rig = source(3)
    for name, content in unpack(formats.write(rig, "colmap").content).items():
        (tmp_path / name).write_bytes(content)
    (config,) = pycolmap.read_rig_config(tmp_path / "rig_config.json")
    assert [camera.ref_sensor for camera in config.cameras] == [True, False, False]
    for i in (1, 2):
        pose = config.cameras[i].cam_from_rig.matrix()
        assert pose[:, :3] == pytest.approx(rig.motion(i).r)
        assert pose[:, 3] == pytest.approx(rig.motion(i).t)
    lines = (tmp_path / "cameras.txt").read_text().splitlines()
    assert [line.split()[0] for line in lines if not line.startswith("#")] == ["1", "2", "3"]


def test_mrcal_models_have_their_poses() -> None:
    rig = source()
    files = unpack(formats.write(rig, "mrcal").content)
    found = [eval(files[f"cam{i}.cameramodel"], {}) for i in (0, 1)]
    assert found[0]["rt_cam_ref"] == [0] * 6
    assert found[1]["rt_cam_ref"] == pytest.approx(rig.poses[1])


def test_gltf_cameras_stand_where_they_are() -> None:
    rig = source()
    scene = json.loads(formats.write(rig, "gltf").content)
    x, y, z = scene["nodes"][1]["translation"]
    centre = -rig.motion(1).r.T @ rig.motion(1).t
    assert (x, -y, -z) == pytest.approx(tuple(centre))


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(CalibrationError, match="opencv-yaml"):
        formats.write(source(), "stl")


def test_cameras_in_one_place_have_no_rectification() -> None:
    rig = source()
    poses = np.array(rig.poses)
    poses[1, 3:] = 0
    content = formats.write(RigSource(rig.cameras, poses), "opencv-yaml").content.decode()
    assert "R: !!opencv-matrix" in content
    assert "R1:" not in content
