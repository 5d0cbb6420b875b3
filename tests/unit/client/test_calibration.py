"""Calibrations of the Python client: use, files, refusals."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from calibdb_client import Calibration, ExportedFile, UsageError

RECORD: dict[str, Any] = {
    "img_size": [64, 48],
    "camera_matrix": [[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]],
    "distortion_coefficients": [-0.2, 0.05, 0, 0, 0],
    "distortion_model": "rectilinear",
    "avg_reprojection_error": 0.2,
    "uncertainty": {"rms": 0.3, "max": 0.9},
    "id": "c4-camera-0123456789ab~64x48~0~rectilinear",
    "camera": "Camera",
    "reliable": True,
}
pytestmark = pytest.mark.usefixtures("working")


def test_frame_is_remapped_by_the_tables_and_one_of_another_size_refused() -> None:
    calibration = Calibration(RECORD)
    frame = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
    straight = cv2.remap(frame, *calibration.remap_tables(), cv2.INTER_LINEAR)
    assert np.array_equal(calibration.undistort(frame), straight)
    with pytest.raises(UsageError, match="32 x 24"):
        calibration.undistort(frame[:24, :32])


def test_saved_file_is_read_back_as_it_was() -> None:
    Calibration(RECORD).save("camera.json")
    assert Calibration.load("camera.json").record == RECORD
    assert [path.name for path in Path().iterdir()] == ["camera.json"]


def test_files_of_calibrations_that_the_service_holds_come_from_it() -> None:
    asked = []

    def export(identifier: str, form: str) -> ExportedFile:
        asked.append((identifier, form))
        return ExportedFile(b"yaml", "x.yaml")

    Calibration(RECORD, export).save("camera.yaml", format="ros")
    assert asked == [(RECORD["id"], "ros")]
    assert Path("camera.yaml").read_bytes() == b"yaml"
    Calibration({**RECORD, "id": None}, export).save("none.yaml", format="ros")
    assert b"plumb_bob" in Path("none.yaml").read_bytes()
    with pytest.raises(UsageError, match="cannot be written"):
        Calibration(RECORD).save("absent/camera.json")


def test_camera_info_has_the_fields_of_ros() -> None:
    info = Calibration(RECORD).camera_info()
    assert info["distortion_model"] == "plumb_bob"
    assert [len(info[name]) for name in ("d", "k", "r", "p")] == [5, 9, 9, 12]
    omni = {**RECORD, "distortion_model": "omnidirectional", "distortion_coefficients": [1.0, 0, 0, 0, 0]}
    with pytest.raises(UsageError, match="ROS has no model"):
        Calibration(omni).camera_info()


@pytest.mark.parametrize(
    "change",
    [
        {"camera_matrix": [[1, 2], [3, 4]]},
        {"img_size": [0, 48]},
        {"distortion_coefficients": [float("nan")] * 5},
        {"camera_matrix": "none"},
        {"distortion_model": None},
    ],
)
def test_record_that_is_no_calibration_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="not a calibration"):
        Calibration({**RECORD, **change})
    Path("x.json").write_text(json.dumps([1]))
    with pytest.raises(UsageError, match="not a calibration"):
        Calibration.load("x.json")
    with pytest.raises(UsageError, match="cannot be read"):
        Calibration.load("absent.json")
