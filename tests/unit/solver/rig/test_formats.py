"""Files of rigs, read back by the tools that they are for."""

import io
import zipfile
from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml

from calibsolver import CalibrationError, Camera
from calibsolver.formats import kalibr
from calibsolver.rig import formats
from calibsolver.rig.formats import RigSource
from calibsolver.rig.rectification import rectify
from tests.helpers.marks import thorough
from tests.helpers.solver import rigs, synthetic


def source() -> RigSource:
    """Two cameras side by side, in metres."""
    rig = rigs.side_by_side(synthetic.rectilinear_cameras(2), 0.12)
    return RigSource(rig.cameras, np.array([m.vector() for m in rig.motions]), "metres")


def unpack(content: bytes) -> dict[str, bytes]:
    """Members of an archive."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


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


@pytest.mark.parametrize("count", [2, *thorough(8)])
def test_kalibr_file_of_cameras_that_it_cannot_hold_turns_none(count: int) -> None:
    lens = [-0.28, 0.09, 0.001, -0.0005, -0.01]
    matrix = np.array([[600.0, 0, 650], [0, 602, 370], [0, 0, 1]])
    camera = Camera("rectilinear", matrix, np.array(lens), (1280, 720))
    rig = RigSource([camera] * count, np.zeros((count, 6)))
    written = formats.write(rig, "kalibr")
    held = kalibr.read(yaml.safe_load(written.content)[f"cam{count - 1}"]).camera
    assert held is not None
    # A fit of keypoints was 2.7 px off on average, 10.6 px in a corner.
    q = np.stack(np.meshgrid(np.linspace(0, 1279, 33), np.linspace(0, 719, 25)), axis=2).reshape(-1, 2)
    away = held.project(camera.unproject(q)) - q
    assert np.linalg.norm(away.mean(axis=0)) < 0.3
    assert np.linalg.norm(away, axis=1).max() <= written.error < 6


def test_mrcal_models_have_their_poses() -> None:
    rig = source()
    files = unpack(formats.write(rig, "mrcal").content)
    found = [eval(files[f"cam{i}.cameramodel"], {}) for i in (0, 1)]
    assert found[0]["rt_cam_ref"] == [0] * 6
    assert found[1]["rt_cam_ref"] == pytest.approx(rig.poses[1])


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
