"""The command: completion in a shell, suggestions for misspelt words, notices about files and pictures."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from calibdb_client.cli import main
from calibdb_client.cli.completion import SHELLS, commands_of, options_of, script
from calibdb_client.cli.output import calibration_facts
from calibdb_client.cli.program import parser
from calibdb_client.pictures import MAX_VIEWS, FoundViews
from calibdb_client.recording import RecordedView
from tests.helpers.command import calibdb


def completed(line: str) -> list[str]:
    """Return the words that bash offers at the end of a line."""
    words = line.split(" ")
    quoted = " ".join(f"'{word}'" for word in words)
    call = f"COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _calibdb; "
    asked = f'{call} echo "${{COMPREPLY[@]}}"'
    run = subprocess.run(
        ["/bin/bash", "-c", script("bash", parser()) + asked], capture_output=True, text=True, check=True
    )
    return run.stdout.split()


def test_bash_completes_commands_and_their_options() -> None:
    assert completed("calibdb ca") == ["calibrate", "cameras"]
    assert completed("calibdb undistort --al") == ["--alpha"]
    assert completed("calibdb check --ag") == ["--against"]
    assert completed("calibdb check pho") == [], "files, which bash completes"


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_and_option_is_in_the_script(shell: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert calibdb(f"completion {shell}") == 0
    text = capfd.readouterr().out
    for name, command in commands_of(parser()).items():
        assert name in text
        for flag in options_of(command):
            long = shell == "fish" and flag.startswith("--")
            assert (f"-l {flag[2:]} " if long else flag.lstrip("-")) in text


def test_command_helps_without_arguments(capfd: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "examples:" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("line", "near"),
    [
        ("check photos --agianst camera.yaml", "--against"),
        ("--versoin", "--version"),
        ("calibrat photos", "'calibrate'"),
    ],
)
def test_misspelt_word_is_answered_with_the_near_one(
    line: str, near: str, capfd: pytest.CaptureFixture[str]
) -> None:
    try:
        status: object = calibdb(line)
    except SystemExit as end:
        status = end.code
    assert status == 2
    assert f"Did you mean {near}?" in capfd.readouterr().err


def said(capfd: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert calibdb("calibrate --offline", *arguments) == 2
    return capfd.readouterr().err


@pytest.mark.usefixtures("working")
def test_folders_without_pictures_are_explained(capfd: pytest.CaptureFixture[str]) -> None:
    Path("parent/left").mkdir(parents=True)
    assert "name one of parent/left" in said(capfd, "parent")
    Path("phone").mkdir()
    for n in range(3):
        Path(f"phone/{n}.HEIC").write_bytes(b"")
    assert "3 HEIC files: convert them" in said(capfd, "phone")
    Path("camera.json").write_text("{}")
    assert "calibdb submit camera.json" in said(capfd, "camera.json")


def test_views_are_limited_for_the_service_only() -> None:
    views = [((640, 480), RecordedView(str(n), (0,), ((0.0, 0.0),))) for n in range(MAX_VIEWS + 25)]
    assert len(FoundViews(views).of_one_size()[1]) == MAX_VIEWS
    assert len(FoundViews(views).of_one_size(limited=False)[1]) == MAX_VIEWS + 25


def test_uncertainty_is_stated_for_the_covered_part() -> None:
    record = {
        "img_size": [1280, 720],
        "camera_matrix": np.array([[420.0, 0, 652], [0, 418, 351], [0, 0, 1]]).tolist(),
        "distortion_coefficients": [-0.25, 0, 0, 0, 0],
        "distortion_model": "rectilinear",
        "uncertainty": {"rms": 0.4, "max": 1.2},
    }
    text = dict(calibration_facts(record))["uncertainty"]
    assert "% of the image that the model covers" in text
    assert "reliable" not in dict(calibration_facts(record))
