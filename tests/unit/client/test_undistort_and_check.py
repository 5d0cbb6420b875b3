"""Commands `undistort` and `check --against`, without a service."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibdb_client import Calibration, offline
from tests.helpers.command import calibdb
from tests.helpers.recordings import recording_of

RECORD = {
    "img_size": [320, 240],
    "camera_matrix": [[300.0, 0, 159.5], [0, 300.0, 119.5], [0, 0, 1]],
    "distortion_coefficients": [-0.25, 0.05, 0, 0, 0],
    "distortion_model": "rectilinear",
}


@pytest.fixture(autouse=True)
def folder(working: Path) -> Path:
    """Folder with a calibration, a picture of a straight line, and a video of it."""
    Path("camera.json").write_text(json.dumps(RECORD))
    frame = np.full((240, 320, 3), 255, dtype=np.uint8)
    x = np.linspace(-0.45, 0.45, 4000)
    line = Calibration(RECORD).project(np.stack([x, np.full_like(x, 0.3), np.ones_like(x)], axis=1))
    q = np.round(line).astype(int)
    frame[q[:, 1], q[:, 0]] = 0
    Path("photos").mkdir()
    cv2.imwrite("photos/line.png", frame)
    cv2.imwrite("photos/again.png", frame)
    writer = cv2.VideoWriter("in.avi", cv2.VideoWriter.fourcc(*"MJPG"), 10, (320, 240))
    for _ in range(3):
        writer.write(frame)
    writer.release()
    return working


def bend(picture: np.ndarray) -> int:
    rows = picture[:, 60:260].mean(axis=2).argmin(axis=0)
    return int(rows.max() - rows.min())


def test_pictures_folders_and_videos_are_straightened(folder: Path) -> None:
    assert bend(cv2.imread("photos/line.png")) >= 3
    assert calibdb("undistort photos/line.png --with camera.json -o out.png") == 0
    assert bend(cv2.imread("out.png")) <= 1
    assert calibdb("undistort photos --with camera.json -o straight --alpha 1") == 0
    assert sorted(path.name for path in (folder / "straight").iterdir()) == ["again.png", "line.png"]
    assert calibdb("undistort in.avi --with camera.json -o out.avi") == 0
    reader = cv2.VideoCapture("out.avi")
    assert int(reader.get(cv2.CAP_PROP_FRAME_COUNT)) == 3
    assert bend(reader.read()[1]) <= 2


def test_pictures_are_not_replaced_and_other_sizes_refused() -> None:
    assert calibdb("undistort photos --with camera.json -o photos") == 2
    cv2.imwrite("small.png", np.zeros((24, 32), dtype=np.uint8))
    assert calibdb("undistort small.png --with camera.json -o x.png") == 2
    assert calibdb("undistort photos --with absent.yaml -o out") == 2


@pytest.mark.usefixtures("no_suggestion")
def test_calibration_at_hand_is_checked_on_fresh_views(capfd: pytest.CaptureFixture[str]) -> None:
    whole = recording_of("opencv_left")
    first = replace(whole, views=whole.views[::2])
    replace(whole, views=whole.views[1::2]).save("fresh.json")
    calibration = offline.calibrate_recording(first, "rectilinear").calibration
    calibration.save("camera.yaml", format="ros")
    assert calibdb("check fresh.json --against camera.yaml --json") == 0
    result = json.loads(capfd.readouterr().out)
    assert (result["fits"], result["views"]) == (True, 6)
    assert result["expected"] <= result["error"] < 2 * result["expected"]
    matrix = calibration.camera_matrix * [[1.05, 1, 1], [1, 1, 1], [1, 1, 1]]
    Calibration({**calibration.record, "camera_matrix": matrix.tolist()}).save("zoomed.json")
    assert calibdb("check fresh.json --against zoomed.json") == 1
    assert calibdb("check fresh.json --against camera.json") == 2, "another size"
