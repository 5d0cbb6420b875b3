"""Rigs from pictures on this machine, of real photographs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibdb_client import CaptureError, Rig, UsageError
from calibdb_client.recording import Recording
from calibdb_client.rig_pictures import _moments, fit_rig
from tests.helpers.command import calibdb
from tests.helpers.data import data_dir, external_data
from tests.helpers.recordings import recording_of


@pytest.fixture(scope="module")
def pair() -> list[Recording]:
    return [recording_of("opencv_left", "left"), recording_of("opencv_right", "right")]


def moments_of(pair: list[Recording]) -> list[dict[int, str]]:
    return [{0: view.source, 1: view.source} for view in pair[0].views]


def baseline(rig: Rig) -> float:
    return float(np.linalg.norm(rig.pose(1)[:3, 3]))


def test_pair_of_real_cameras_has_the_baseline_of_opencvs_calibration(pair: list[Recording]) -> None:
    """cv2.stereoCalibrate: 3.3140 squares, once the view that is numbered from the other side is turned."""
    result = fit_rig(pair, moments_of(pair), pair[0].board, "rectilinear", None, [])
    assert baseline(result.rig) == pytest.approx(3.314, abs=0.01)
    assert result.rig.rms < 0.35
    assert result.moments == 13
    sentence = result.board_sentence(square_mm=25)
    assert sentence == "Your board is bent by 0.2 mm; that was taken into account."


def test_pictures_of_two_moments_are_set_aside_and_named(pair: list[Recording]) -> None:
    moments = moments_of(pair)
    moments[3], moments[9] = {0: moments[3][0], 1: moments[9][1]}, {0: moments[9][0], 1: moments[3][1]}
    result = fit_rig(pair, moments, pair[0].board, "rectilinear", 0.025, [])
    names = {name.split("/")[1] for name, why in result.left_out if "not of one moment" in why}
    assert names
    assert names <= {"03.jpg", "09.jpg"}
    assert baseline(result.rig) == pytest.approx(3.314 * 0.025, abs=0.0005)


def test_pictures_are_paired_by_name_or_by_order() -> None:
    left, right = ([Path(side, f"{n}.png") for n in names] for side, names in (("l", "abc"), ("r", "bcd")))
    assert _moments([left, right]) == [
        {0: "a.png"},
        {0: "b.png", 1: "b.png"},
        {0: "c.png", 1: "c.png"},
        {1: "d.png"},
    ]
    numbered = [[Path(f"{side}{n}.png") for n in range(3)] for side in ("left", "right")]
    assert _moments(numbered)[2] == {0: "left2.png", 1: "right2.png"}
    with pytest.raises(UsageError, match="3, 2 images"):
        _moments([numbered[0], numbered[1][:2]])


def test_cameras_that_share_too_little_are_refused(pair: list[Recording]) -> None:
    few = replace(pair[1], views=pair[1].views[:2])
    with pytest.raises(CaptureError, match="2 moments show the board in two cameras"):
        fit_rig([pair[0], few], moments_of(pair), pair[0].board, "rectilinear", None, [])


@external_data
@pytest.mark.thorough
@pytest.mark.usefixtures("working")
def test_rig_of_fisheyes_is_calibrated_from_two_folders() -> None:
    """The fit of all 34 pairs has a baseline of 4.076 squares."""
    for side in ("left", "right"):
        Path(side).mkdir()
        for path in sorted((data_dir() / "photos" / f"chessboard_omnidir_{side}").iterdir())[::4]:
            (Path(side) / path.name).symlink_to(path)
    assert calibdb("rig left right --kind chessboard --squares 9x7 -o rig.yaml") == 0
    rig = Rig.load("rig.calibdb.json")
    assert baseline(rig) == pytest.approx(4.076, rel=0.01)
    assert {camera.distortion_model for camera in rig.calibrations} <= {"fisheye", "omnidirectional"}
    assert b"T_cn_cnm1" in Path("rig.yaml").read_bytes()
