"""The operator's command line for programs and people: JSON, dry runs, questions, plots, several files."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from calibsolver import formats
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.data import ROOT
from tests.helpers.service.index_items import items
from tests.helpers.service.published import calibration, publish
from tests.helpers.solver.export_sources import subject

WHOSE = ["--camera", "Microsoft LifeCam HD-3000 (045e:0779)", "--platform", "X11; Linux x86_64"]


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """A folder with six calibrations of one camera, of which one disagrees, and a token; its key and id."""
    folder = tmp_path_factory.mktemp("terminal") / "data"
    documents = [calibration("Plotted 1234", n) for n in range(5)]
    documents.append(calibration("Plotted 1234", 5, fx=1040.0, fy=1038.0))
    with Server(folder) as stack:
        publish(stack, *documents)
    with pytest.MonkeyPatch.context() as patch, io.StringIO() as screen:
        patch.setenv("DATA_DIR", str(folder))
        patch.setattr(sys, "stdout", screen)
        assert main(["token", "create", "--plan", "page", "--json"]) == 0
        token = json.loads(screen.getvalue())["token"]
    return folder, documents[0].camera_key, token.split("_")[1]


@pytest.fixture(autouse=True)
def on_it(made: tuple[Path, str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DATA_DIR", str(made[0]))


def everything(folder: Path) -> tuple[Any, list[tuple[str, str]]]:
    """Items of the table, and names and tags of the objects."""
    with Server(folder) as stack:
        objects = stack.storage.objects
        return items(stack), [(name, str(objects.get(name))) for name in objects.names("")]


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    """Run a command with `--json`; return its document."""
    capsys.readouterr()
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_listings_are_json_for_programs(
    made: tuple[Path, str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    _, key, token_id = made
    token = next(token for token in told(capsys, "token", "list") if token["id"] == token_id)
    assert (token["plan"], token["origins"]) == ("page", [])
    assert "secret" not in json.dumps(token)
    assert told(capsys, "camera", "list") == [{"key": key, "calibrations": 6, "withdrawn": 0}]
    shown = told(capsys, "camera", "show", key)
    (mode,) = shown["modes"]
    assert (mode["img_size"], mode["zoom"]) == ([1280, 720], 0.0)
    assert len(mode["calibrations"]) == 6
    assert {c["distortion_model"] for c in mode["consensuses"]} >= {"rectilinear"}
    assert told(capsys, "backfill", "--dry-run") == {"modes": 1, "changed": 0, "failed": 0}


def test_dry_run_changes_nothing(
    made: tuple[Path, str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, key, token_id = made
    contributor, one = (
        told(capsys, "camera", "show", key)["modes"][0]["calibrations"][0][k] for k in ("contributor", "id")
    )
    assert main(["dump", "--private", str(tmp_path / "dump")]) == 0
    guess = tmp_path / "camera.yaml"
    guess.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    rows = tmp_path / "rows.csv"
    rows.write_text(
        "camera,platform,w,h,fx,fy,cx,cy,k1,k2,p1,p2,k3\n"
        "C920 (046d:082d),Linux,640,480,500,500,320,240,0,0,0,0,0\n"
    )
    before = everything(folder)
    for command, said in (
        (["token", "revoke", token_id], f"would be revoked: {token_id}"),
        (["token", "rotate", token_id], f"would get a new secret: {token_id}"),
        (["calibration", "withdraw", one], f"would be withdrawn: {one}"),
        (["calibration", "unname", one], f"would lose its name: {one} (it has none)"),
        (
            ["contributor", "forget", contributor],
            "would be removed: 1 calibrations, 0 sessions, 0 votes",
        ),
        (["reindex"], "6 calibrations, 0 votes, 2 tokens to index; 0 calibrations to publish, 0 stale"),
        (["backfill"], "1 modes of cameras would be checked"),
        (["load", str(tmp_path / "dump")], "6 calibrations and 0 votes would be stored"),
        (["import", str(guess), *WHOSE], "a first guess"),
        (["seed", str(rows)], "1 rows: 1 first guesses for 1 cameras would be stored"),
    ):
        capsys.readouterr()
        assert main([*command, "--dry-run"]) == 0, command
        assert said in capsys.readouterr().out, command
    assert main(["calibration", "restore", one, "--dry-run"]) == 1
    assert everything(folder) == before


@pytest.mark.parametrize("answer", ["n", "y"])
def test_person_is_asked_before_a_token_is_revoked(
    answer: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    token_id = told(capsys, "token", "create")["token"].split("_")[1]
    monkeypatch.setattr(sys, "stdin", Terminal(f"{answer}\n"))
    assert main(["token", "revoke", token_id]) == (0 if answer == "y" else 1)
    assert f"Revoke for good: {token_id}" in capsys.readouterr().err
    left = {token["id"] for token in told(capsys, "token", "list")}
    assert (token_id in left) == (answer == "n")


def test_person_is_told_what_forgetting_removes_and_may_say_no(
    made: tuple[Path, str, str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, key, _ = made
    contributor = told(capsys, "camera", "show", key)["modes"][0]["calibrations"][0]["contributor"]
    before = everything(folder)
    monkeypatch.setattr(sys, "stdin", Terminal("n\n"))
    assert main(["contributor", "forget", contributor]) == 1
    assert "Remove 1 calibrations, 0 sessions, 0 votes, 0 rigs for good?" in capsys.readouterr().err
    assert everything(folder) == before


def test_terminal_shows_calibrations_as_a_table(
    made: tuple[Path, str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", screen := Terminal())
        assert main(["camera", "show", made[1]]) == 0
    assert "contributor" in screen.getvalue()
    assert "┃" in screen.getvalue()
    assert screen.getvalue().count(f"│ {made[1]}-") == 6


def test_plot_draws_members_and_the_one_that_disagrees(
    made: tuple[Path, str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["camera", "show", made[1], "--plot"]) == 0
    plot = capsys.readouterr().out.partition("difference from the consensus")
    drawn = plot[0] + plot[2]
    assert "members (5)" in drawn
    assert "alone (1)" in drawn
    assert "fx (px)" in drawn
    assert drawn.count("x") >= 2  # its marker, in the legend and in the picture


def test_each_of_several_files_is_stored_or_refused_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    good = [tmp_path / name for name in ("one.yaml", "two.yaml")]
    for path in good:
        path.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    bad = tmp_path / "bad.yaml"
    bad.write_text("[")
    assert main(["import", str(good[0]), str(bad), str(good[1]), *WHOSE]) == 1
    said = capsys.readouterr()
    assert [line.split(": ")[0] for line in said.out.splitlines()] == [str(path) for path in good]
    assert f"1 of 3 files could not be used: {bad}" in said.err.splitlines()[-1]
    assert main(["import", str(good[0]), str(bad), *WHOSE, "--json"]) == 1
    results = json.loads(capsys.readouterr().out)
    assert [sorted(result) for result in results] == [["file", "result"], ["error", "file"]]


@pytest.mark.parametrize(
    "arguments",
    [[], ["nothing"], ["token"], ["token", "rotate", "x", "--grace", "-1"], ["camera", "show"]],
    ids=" ".join,
)
def test_wrong_command_line_exits_with_two(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2


def test_shell_completes_plans() -> None:
    environment = {
        **os.environ,
        "_CALIBDB_OPS_COMPLETE": "complete_bash",
        "COMP_WORDS": "calibdb-ops token create --plan pa",
        "COMP_CWORD": "4",
    }
    command = [ROOT / "infra" / "calibdb-ops"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["page", "partner"]
