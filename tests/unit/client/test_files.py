"""Files of other tools, written and read without a service: of a calibration of real photographs."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibdb_client import Calibration, UsageError
from calibdb_client.conversion import format_of
from tests.helpers.command import calibdb

pytestmark = pytest.mark.usefixtures("working")


@pytest.fixture(scope="module")
def calibrated(left_file: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("files") / "left.json"
    path.write_bytes(left_file)
    return path


def test_suffix_chooses_the_format_and_never_contradicts_it(calibrated: Path) -> None:
    calibration = Calibration.load(calibrated)
    calibration.save("camera.cameramodel")
    assert calibration.save("corners.vnl").content.count(b"\n") > 13 * 54
    assert b"optimization_inputs" in Path("camera.cameramodel").read_bytes()
    assert calibration.save("x.txt").content.count(b"OPENCV") == 1
    assert calibration.save("x.yaml", format="kalibr").content.count(b"cam0:") == 1
    assert format_of("opencv", "x.json") == "opencv-json"
    assert format_of("opencv", "x.yml") == "opencv-yaml"
    with pytest.raises(UsageError, match="ros or kalibr"):
        calibration.save("y.yaml")
    with pytest.raises(UsageError, match=r"suffix of mrcal"):
        calibration.save("y.cameramodel", format="ros")
    with pytest.raises(UsageError, match="no format is called 'rosy'"):
        calibration.save("y.yaml", format="rosy")
    assert calibdb(f"export {calibrated} -o z.yaml") == 2
    assert not list(Path().glob("[yz].*"))


def test_changed_picture_is_exported(calibrated: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert calibdb(f"export {calibrated} --format calibdb --resize 320x240") == 0
    half = json.loads(capfdbinary.readouterr().out)
    whole = Calibration.load(calibrated).camera_matrix
    assert half["img_size"] == [320, 240]
    assert half["camera_matrix"][0][0] == pytest.approx(whole[0, 0] / 2)
    assert half["camera_matrix"][0][2] == pytest.approx((whole[0, 2] + 0.5) / 2 - 0.5)


def test_file_of_another_tool_is_converted_and_loaded() -> None:
    source = "camera.yml"
    storage = cv2.FileStorage(source, cv2.FILE_STORAGE_WRITE)
    matrix = np.array([[810.0, 0, 640], [0, 812, 360], [0, 0, 1]])
    storage.write("image_width", 1280)
    storage.write("image_height", 720)
    storage.write("camera_matrix", matrix)
    storage.write("distortion_coefficients", np.array([[-0.3, 0.1, 0.001, -0.002, 0.01]]))
    storage.release()
    assert calibdb(f"convert {source} -o camera.cameramodel") == 0
    loaded = Calibration.load("camera.cameramodel")
    assert np.array_equal(loaded.camera_matrix, matrix)
    assert np.isnan(loaded.avg_reprojection_error)
    assert np.array_equal(Calibration.load(source).distortion_coefficients, loaded.distortion_coefficients)
    Path("board.txt").write_text("a board, glued to a table\n")
    assert calibdb("convert board.txt --format ros") == 2
