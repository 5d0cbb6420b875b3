"""The Python client and its command against the local stack."""

import json
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from calibdb_client import Board, Client, CredentialError, NotFoundError, Recording, session
from calibdb_client.cli import main
from infra.server.server import Server
from tests.helpers import board_pictures
from tests.helpers.service.client import Client as Raw
from tests.helpers.service.client import Truth
from tests.helpers.service.commands import run
from tests.helpers.service.published import calibration, publish

LABEL, PLATFORM, SIZE = "HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", (1280, 720)
LOOKUP = ["lookup", "--label", LABEL, "--platform", PLATFORM, "--size", "1280x720", "--no-cache"]
TOKEN = "cdb_dev_local"
EXAMPLES = Path(__file__).parents[2] / "clients/python/examples"


@pytest.fixture(scope="module", autouse=True)
def known(stack: Server) -> dict[str, Any]:
    publish(stack, *(calibration(LABEL, n) for n in range(5)))
    return Raw(stack).lookup(camera=LABEL).json


def test_three_lines_look_a_camera_up(served: str, known: dict[str, Any]) -> None:
    with Client(served, TOKEN, cache=False) as client:
        answer = client.lookup(LABEL, platform=PLATFORM, size=SIZE)
        assert answer.calibration.record == known
        assert abs(answer.calibration.camera_matrix[0, 0] - Truth().fx) < 3
        missing = client.lookup("Unheard Camera (1234:5678)", platform=PLATFORM, size=SIZE)
        assert (missing.calibration, missing.reason) == (None, "unknown_camera")
        assert "1234" in missing.guidance_url
        again = client.calibration(answer.calibration.id)
        assert np.allclose(again.camera_matrix, answer.calibration.camera_matrix)
        (camera,) = client.cameras("c920")
        assert client.camera(camera["key"])["camera"] == LABEL
        with pytest.raises(NotFoundError):
            client.camera("c4-absent-0123456789ab")
    with Client(served, "cdb_wrong_token", cache=False) as stranger, pytest.raises(CredentialError):
        stranger.cameras()


@pytest.mark.usefixtures("served")
def test_commands_print_the_answers_of_the_api(known: dict[str, Any]) -> None:
    assert run(main, *LOOKUP, "--json").document == known
    assert "focal lengths" in run(main, *LOOKUP).out
    assert yaml.safe_load(run(main, *LOOKUP, "--format", "ros").out)["image_height"] == 720
    printed = run(main, *LOOKUP, "--label", "Unheard Camera (1234:5678)", "--json", status=1)
    assert printed.document["reason"] == "unknown_camera"
    assert "calibrate it in a browser: http" in printed.err
    assert run(main, "cameras", "c920", "--json").document["cameras"][0]["camera"] == LABEL
    run(main, "cameras", "absent", status=1)


@pytest.mark.usefixtures("served")
def test_export_command_writes_the_file(known: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "half.yaml"
    printed = run(main, "export", known["id"], "--format", "kalibr", "--resize", "640x360", "-o", path)
    assert yaml.safe_load(path.read_bytes())["cam0"]["resolution"] == [640, 360]
    assert printed.out == ""
    run(main, "export", "c4-absent-0123456789ab~640x480~0~rectilinear", status=1)
    run(main, "export", "../tokens", status=2)


@pytest.mark.usefixtures("served")
def test_wrong_token_and_absent_service_have_their_statuses(monkeypatch: pytest.MonkeyPatch) -> None:
    refused = run(main, *LOOKUP, "--token", "cdb_wrong_token", "--label", "Camera x", status=4)
    assert "CALIBDB_TOKEN" in refused.err
    monkeypatch.setattr("time.sleep", lambda _: None)
    (line,) = run(main, *LOOKUP, "--url", "http://127.0.0.1:9", status=3).err.splitlines()
    assert "no connection" in line
    monkeypatch.delenv("CALIBDB_URL")
    run(main, *LOOKUP, status=2)


@pytest.mark.usefixtures("served")
def test_folder_of_pictures_becomes_a_calibration_of_the_database(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "chosen_model", lambda *_: ("rectilinear", None))
    folder = board_pictures.write(tmp_path / "pictures", Board(), count=5)
    path = tmp_path / "camera.json"
    drawn = ["--squares", "9x6", "--label", "Drawn camera"]
    result = run(main, "calibrate", folder, *drawn, "-o", path, "--json").document
    assert result["img_size"] == list(board_pictures.SIZE)
    assert np.abs(np.array(result["camera_matrix"]) - board_pictures.MATRIX).max() < 5
    with Client(cache=False) as client:
        stored = client.calibration(result["id"])
        assert np.allclose(stored.camera_matrix, result["camera_matrix"])
        assert stored.record["platform"] == "photographs"
        again = client.submit(Recording.load(path))
        assert np.allclose(again.calibration.camera_matrix, stored.camera_matrix)
        assert again.used == 5
        compared = client.check_against(Recording.load(path), stored)
    checked = run(main, "check", path, "--against", result["id"], "--json").document
    assert (checked["fits"], checked["views"], checked["drift"]) == (True, 5, compared.drift)
    assert compared.drift < 2


@pytest.mark.usefixtures("served")
def test_ros_node_writes_what_camera_info_manager_reads(
    known: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program = ["ros_camera_info.py", "--label", LABEL, "--folder", str(tmp_path), "--name", "head"]
    monkeypatch.setattr("sys.argv", program)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(EXAMPLES / "ros_camera_info.py"), run_name="__main__")
    assert ended.value.code == 0
    message = json.loads(capsys.readouterr().out)
    written = yaml.safe_load((tmp_path / "head.yaml").read_bytes())
    assert written["camera_matrix"]["data"] == message["k"]
    assert written["distortion_coefficients"]["data"] == message["d"]
    assert message["k"] == np.ravel(known["camera_matrix"]).tolist()
