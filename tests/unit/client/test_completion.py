"""Completion in a shell, and suggestions for misspelt options."""

import subprocess

import pytest

from calibdb_client.cli import main
from calibdb_client.cli.completion import SHELLS, commands_of, options_of, script
from calibdb_client.cli.program import parser


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
    assert main(["completion", shell]) == 0
    text = capfd.readouterr().out
    for name, command in commands_of(parser()).items():
        assert name in text
        for flag in options_of(command):
            long = shell == "fish" and flag.startswith("--")
            assert (f"-l {flag[2:]} " if long else flag.lstrip("-")) in text


def test_misspelt_option_is_answered_with_the_near_one(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["check", "photos", "--agianst", "camera.yaml"])
    assert end.value.code == 2
    assert "Did you mean --against?" in capfd.readouterr().err
    with pytest.raises(SystemExit):
        main(["--versoin"])
    assert "Did you mean --version?" in capfd.readouterr().err
