"""Rigs of the Python client: poses against OpenCV, units, files, and what is refused."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from calibdb_client import ExportedFile, Rig, UsageError
from tests.helpers.command import calibdb
from tests.unit.client.test_calibration import RECORD

RIG = "1f0c7a3e5b2d49688c1e0f7d6a5b4c3d"
POSES = ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.02, -0.6, 0.1, -2.0, 0.1, 0.7), (0.3, -1.2, 2.4, 1.0, 2.0, -3.0))
RESULT: dict[str, Any] = {
    "rig_id": RIG,
    "cameras": ["a", "b", "c"],
    "calibrations": [RECORD] * 3,
    "extrinsics": [
        {"position": i, "rvec": pose[:3], "tvec": pose[3:], "std": [0.001] * 3 + [0.02] * 3}
        for i, pose in enumerate(POSES)
    ],
    "unit": "squares",
    "rms": 0.27,
    "held_out_rms": 0.3,
    "uncertainty": {"rotation_deg": 0.05, "translation_percent": 0.2, "rms": 0.25},
    "verdict": {"level": "fair", "reasons": ["held_out"]},
    "board_poses": [{"moment": "m1", "rvec": [0.1, 0, 0], "tvec": [-4, -3, 12]}],
}


def test_record_is_read_and_its_files_come_from_the_service() -> None:
    camchain = ExportedFile(b"cam0:\n", "camchain.yaml")
    rig = Rig(RESULT, lambda identifier, form: replace(camchain, filename=f"{identifier}.{form}"))
    assert (rig.id, rig.unit, rig.verdict, rig.rms) == (RIG, "squares", ("fair", "held_out"), 0.27)
    assert rig.uncertainty == RESULT["uncertainty"]
    assert [each.camera for each in rig.calibrations] == [RECORD["camera"]] * 3
    assert rig.export("kalibr").filename == f"{RIG}.kalibr"


def test_poses_are_opencvs() -> None:
    rig, pose = Rig(RESULT), POSES[1]
    assert rig.pose(1)[:3, :3] == pytest.approx(cv2.Rodrigues(np.array(pose[:3]))[0], abs=1e-12)
    assert rig.pose(1)[:, 3].tolist() == [*pose[3:], 1]
    assert rig.pose(2, origin=1) @ rig.pose(1) == pytest.approx(rig.pose(2))
    with pytest.raises(UsageError, match="cameras 0 to 2, and no camera 3"):
        rig.pose(3)


def test_a_rig_in_squares_becomes_one_in_metres() -> None:
    rig = Rig(RESULT)
    metres = rig.to_metres(0.03)
    assert (metres.unit, rig.unit) == ("metres", "squares")
    assert metres.pose(1)[:3, 3] == pytest.approx(np.array(POSES[1][3:]) * 0.03)
    assert metres.std(1) == pytest.approx([0.001] * 3 + [0.0006] * 3)
    assert metres.record["board_poses"][0]["tvec"] == pytest.approx([-0.12, -0.09, 0.36])
    assert metres.to_metres(5) is metres
    with pytest.raises(UsageError, match="above 0 metres"):
        rig.to_metres(0)


@pytest.mark.usefixtures("working")
def test_files_are_written_and_read_again() -> None:
    rig = Rig(RESULT)
    rig.save("rig.json")
    again = Rig.load("rig.json")
    assert again.pose(1) == pytest.approx(rig.pose(1))
    assert b"T_cn_cnm1" in again.save("camchain.yaml").content
    assert calibdb("export rig.json --format opencv_stereo -o stereo.zip") == 0
    assert zipfile.ZipFile("stereo.zip").namelist() == ["stereo-0-1.yml", "stereo-0-2.yml"]
    with pytest.raises(UsageError, match="suffix of json"):
        again.save("camchain.json", format="kalibr")
    Path("list.json").write_text("[]")
    for name, content in (("none.json", "{}"), ("half.json", json.dumps({**RESULT, "calibrations": []}))):
        Path(name).write_text(content)
    for name in ("list.json", "none.json", "half.json", "nowhere.json"):
        with pytest.raises(UsageError):
            Rig.load(name)
