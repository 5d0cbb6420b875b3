"""Parameters that the command holds: `--fix` and `--start`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibdb_client import Calibration, offline
from calibdb_client.report import fit_again
from tests.helpers.command import calibdb
from tests.helpers.recordings import recording_of

pytestmark = pytest.mark.usefixtures("no_suggestion")
CORNERS = "corners.json"
FEW = replace(recording_of("opencv_left"), views=recording_of("opencv_left").views[::3])


@pytest.fixture(autouse=True)
def corners(working: Path) -> None:
    FEW.save(working / CORNERS)


def test_submit_fixes_values_and_keeps_their_names() -> None:
    fixed = ["--model", "rectilinear", "--fix", "cx=320,cy=240,k3"]
    assert calibdb(f"submit {CORNERS} --offline", *fixed) == 0
    found = Calibration.load(CORNERS)
    assert found.camera_matrix[:2, 2].tolist() == [320, 240]
    assert found.distortion_coefficients[4] == 0
    assert found.record["fixed"] == ["cx", "cy", "k3"]
    assert found.covariance is not None
    assert np.diagonal(found.covariance)[[2, 3, 8]].tolist() == [0, 0, 0]
    assert found.recording is not None
    again, _ = fit_again(found.recording, found)  # of reports
    assert again.camera.matrix[:2, 2].tolist() == [320, 240]


def test_start_gives_model_and_values() -> None:
    first = offline.calibrate_recording(FEW, "fisheye", fix="aspect").calibration
    assert first.camera_matrix[0, 0] == pytest.approx(first.camera_matrix[1, 1], rel=1e-12)
    first.save("first.json")
    assert calibdb(f"submit {CORNERS} --offline --start first.json --fix fx,fy") == 0
    found = Calibration.load(CORNERS)
    assert found.distortion_model == "fisheye"
    assert found.camera_matrix[0, 0] == first.camera_matrix[0, 0]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--fix", "center"], "--offline"),
        (["--offline", "--fix", "fx=wide"], "not a number"),
        (["--offline", "--fix", "skew"], "to fix, only fx"),
        (["--offline", "--fix", "fx"], "fx needs a value"),
    ],
)
def test_what_cannot_be_fixed_is_a_usage_error(
    options: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert calibdb(f"submit {CORNERS} --label Camera --model rectilinear", *options) == 2
    assert says in capsys.readouterr().err


def test_live_captures_are_refused_with_the_way_to_go() -> None:
    assert calibdb("calibrate 0 --offline --fix center") == 2
