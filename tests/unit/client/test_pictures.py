"""Calibration from pictures on this machine: drawn ones with a known truth, and real photographs."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image

from calibdb_client import Board, Calibration, CaptureError, Recording, UsageError, offline, pictures
from calibdb_client.cli import main
from calibdb_client.pictures import FoundViews, picture_paths, read, turned_by_camera
from calibsolver import fit
from calibsolver.capture.rules import MAX_POINTS
from tests.helpers import board_pictures
from tests.helpers.command import calibdb
from tests.helpers.data import data_dir, external_data, float32
from tests.helpers.recordings import recording_of

BOARD = ["--model", "rectilinear", "--squares", "9x6"]
PHOTOGRAPHS = ["--squares", "8x8", "--marker-ratio", "0.75", "--dictionary", "DICT_4X4_1000"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return board_pictures.write(tmp_path_factory.mktemp("drawn"), Board(), 4)


@pytest.mark.usefixtures("no_suggestion")
def test_folder_is_calibrated_offline(folder: Path, working: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert calibdb(f"calibrate {folder} --offline --json") == 0
    told = capfd.readouterr()
    (path,) = working.iterdir()
    calibration = Calibration.load(path)
    assert json.loads(told.out)["camera_matrix"] == calibration.camera_matrix.tolist()
    sigma = calibration.uncertainty["rms"]
    assert np.abs(calibration.camera_matrix - board_pictures.MATRIX).max() < 3 * sigma + 1
    assert len(Recording.load(path).views) == 4
    assert calibdb(f"submit {path}") == 2, "the camera is not named"
    assert calibdb(f"calibrate {folder} --offline", *BOARD) == 0
    (other,) = set(working.iterdir()) - {path}  # an earlier capture is never replaced
    assert np.allclose(Calibration.load(other).camera_matrix, calibration.camera_matrix)


def test_service_that_is_not_there_loses_no_corner(
    folder: Path, working: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert calibdb(f"calibrate {folder} --label Camera -o kept.json", *BOARD) == 2
    assert "calibdb submit kept.json" in capfd.readouterr().err
    assert len(Recording.load(working / "kept.json").views) == 4
    assert [path.name for path in working.iterdir()] == ["kept.json"]


def test_interruption_keeps_what_was_found(
    folder: Path, working: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def stop(*arguments: Any) -> None:
        read(*arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr("calibdb_client.cli.calibrate.read", stop)
    assert calibdb(f"calibrate {folder} --offline -o kept.json", *BOARD) == 130
    assert "calibdb submit kept.json" in capfd.readouterr().err
    assert len(Recording.load(working / "kept.json").views) == 4


@pytest.mark.usefixtures("no_suggestion")
def test_command_says_what_it_leaves_out_and_writes_another_tools_file(
    working: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Photographs with an EXIF orientation, next to pictures of another size and other files."""
    mixed = board_pictures.write(working / "mixed", Board(), 5)
    turned = Image.Exif()
    turned[0x0112] = 6
    for path in list(mixed.iterdir()):
        Image.open(path).save(path.with_suffix(".jpg"), quality=98, exif=turned)
        path.unlink()
    assert turned_by_camera(sorted(mixed.iterdir()))
    small = board_pictures.picture(Board(), (0.2, 0.2, 0))
    cv2.imwrite(str(mixed / "small.png"), cv2.resize(small, (600, 450)))
    cv2.imwrite(str(mixed / "empty.png"), np.full((480, 640), 128, np.uint8))
    (mixed / "broken.jpg").write_bytes(b"\xff\xd8 no picture")
    (mixed / "zero.png").write_bytes(b"")
    (mixed / "notes.txt").write_text("no picture, and not read")
    command = ["calibrate", str(mixed), *BOARD, "--offline", "-v", "-o", "camera.yaml"]
    assert main(command) == 2, "ros or kalibr"
    assert main([*command, "--format", "ros"]) == 0
    said = capfd.readouterr()
    assert "1 pictures of another size than 640x480" in said.err
    assert "2 files are not images: broken.jpg, zero.png" in said.err
    assert "empty.png" in said.err
    assert "EXIF orientation" in said.err
    rows = re.findall(r"^\d\d\.jpg +\d+ +\d+ +(0\.\d+)$", said.out, re.MULTILINE)
    assert len(rows) == 5, "name, corners found and used, and rms of each picture"
    assert max(map(float, rows)) < 0.2
    kept = Calibration.load("camera.calibdb.json")
    assert kept.recording is not None
    assert len(kept.recording.views) == 5
    content = yaml.safe_load(Path("camera.yaml").read_text())
    assert content["camera_matrix"]["data"] == kept.camera_matrix.ravel().tolist()


def test_too_few_pictures_and_another_board_are_said(
    folder: Path, working: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    three = [str(path) for path in sorted(folder.iterdir())[:3]]
    assert calibdb("calibrate --offline", *three, *BOARD) == 7
    assert "detected in 3 pictures, and 4 are needed" in capfd.readouterr().err
    assert calibdb("calibrate --offline --dictionary DICT_7X7_50", *three) == 7
    assert "--dictionary" in capfd.readouterr().err
    for wrong in ([str(working)], [str(working / "absent")], [str(folder)]):
        assert calibdb("calibrate", *wrong) == 2
    assert list(working.iterdir()) == []


def test_many_files_are_sampled_evenly(tmp_path: Path) -> None:
    for n in range(500):
        (tmp_path / f"{n:05}.jpg").touch()
    paths = picture_paths([tmp_path])
    assert len(paths) == 500
    done: list[tuple[int, int]] = []
    found = FoundViews()
    read(paths, Board(), found, lambda *each: done.append(each))
    assert done[-1] == (pictures.MAX_PICTURES, pictures.MAX_PICTURES)
    assert found.unreadable[-1] == "00498.jpg"
    with pytest.raises(CaptureError, match="none of the files can be read"):
        found.of_one_size()


def test_bounds_are_the_services() -> None:
    assert pictures.MAX_POINTS <= MAX_POINTS


@pytest.mark.parametrize(
    "content", ["", "[]", "{}", '{"recording": {"format": "calibdb-recording-9"}}', '{"recording": []}']
)
def test_file_that_is_no_recording_is_refused(content: str, tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    path.write_text(content)
    with pytest.raises(UsageError):
        Recording.load(path)
    with pytest.raises(UsageError):
        Recording.load(tmp_path / "absent.json")


@external_data
@pytest.mark.thorough
def test_real_photographs_give_opencvs_focal_length(working: Path) -> None:
    """With the board as drawn, OpenCV's; in its shape, one that the error bars reach."""
    photographs = data_dir() / "photos" / "charuco_1280x720"
    options = [*PHOTOGRAPHS, "--model", "rectilinear", "-o", "camera.json"]
    assert calibdb(f"calibrate {photographs} --offline", *options) == 0
    recording = Recording.load(working / "camera.json")
    assert len(recording.views) == 16
    views, size = recording.observations(), recording.key.img_size
    _, matrix, _, _, _, std, *_ = cv2.calibrateCameraExtended(*float32(views), size, None, None)
    drawn = fit(views, size, board_shape=False).camera
    found = Calibration.load(working / "camera.json")
    off = np.abs([np.diag(c)[:2] - np.diag(matrix)[:2] for c in (drawn.matrix, found.camera_matrix)])
    assert off[0].max() < 0.05
    assert (off[0] / std.ravel()[:2]).max() < 1
    assert (off[1] / np.sqrt(np.diagonal(found.record["covariance"])[:2])).max() < 1


def test_failure_names_the_model_that_fits(
    working: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    left, wide = recording_of("jy_left"), recording_of("babel_ov_plane")
    replace(left, views=left.views[::4]).save(working / "left.json")
    replace(wide, views=wide.views[::8]).save(working / "wide.json")
    assert calibdb("submit left.json --offline --model rectilinear") == 0
    assert "--model omnidirectional explains these pictures better" in capfd.readouterr().err
    monkeypatch.setattr(offline, "chosen_model", lambda *_: ("rectilinear", "fisheye"))
    assert calibdb("submit wide.json --offline --model rectilinear") == 7
    assert "--model fisheye fits them" in capfd.readouterr().err
