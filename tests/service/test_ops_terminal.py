"""The operator's command line for programs and people."""

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
from tests.helpers.service.commands import Operator, Terminal
from tests.helpers.service.index_items import items
from tests.helpers.service.published import calibration, publish
from tests.helpers.solver.export_sources import subject

WHOSE = ["--camera", "Microsoft LifeCam HD-3000 (045e:0779)", "--platform", "X11; Linux x86_64"]
KEY = calibration("Plotted 1234", 0).camera_key


@pytest.fixture(scope="module")
def operator(tmp_path_factory: pytest.TempPathFactory) -> Operator:
    operator = Operator(tmp_path_factory.mktemp("terminal") / "data")
    documents = [calibration("Plotted 1234", n) for n in range(5)]
    documents.append(calibration("Plotted 1234", 5, fx=1040.0, fy=1038.0))
    with Server(operator.folder) as stack:
        publish(stack, *documents)
    return operator


@pytest.fixture
def token_id(operator: Operator) -> str:
    return str(operator.document("token", "create", "--plan", "page")["token"].split("_")[1])


@pytest.fixture
def contributor(operator: Operator) -> str:
    [mode] = operator.document("camera", "show", KEY)["modes"]
    return str(mode["calibrations"][0]["contributor"])


def everything(operator: Operator) -> tuple[Any, list[tuple[str, bytes | None]]]:
    with Server(operator.folder) as stack:
        objects = stack.storage.objects
        return items(stack), [(name, objects.get(name)) for name in objects.names("")]


def test_listings_are_json_for_programs(operator: Operator, token_id: str) -> None:
    [token] = [token for token in operator.document("token", "list") if token["id"] == token_id]
    assert (token["plan"], token["origins"]) == ("page", [])
    assert "secret" not in json.dumps(token)
    assert operator.document("camera", "list") == [{"key": KEY, "calibrations": 6, "withdrawn": 0}]
    [mode] = operator.document("camera", "show", KEY)["modes"]
    assert len(mode["calibrations"]) == 6
    assert "rectilinear" in {c["distortion_model"] for c in mode["consensuses"]}
    assert operator.document("backfill", "--dry-run") == {"modes": 1, "changed": 0, "failed": 0}


def test_dry_run_changes_nothing(operator: Operator, token_id: str, contributor: str, tmp_path: Path) -> None:
    operator("dump", "--private", tmp_path / "dump")
    guess = tmp_path / "camera.yaml"
    guess.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    rows = tmp_path / "rows.csv"
    rows.write_text(
        "camera,platform,w,h,fx,fy,cx,cy,k1,k2,p1,p2,k3\n"
        "C920 (046d:082d),Linux,640,480,500,500,320,240,0,0,0,0,0\n"
    )
    before = everything(operator)
    one = calibration("Plotted 1234", 0).id
    for command, printed in (
        (["token", "revoke", token_id], f"would be revoked: {token_id}"),
        (["token", "rotate", token_id], f"would get a new secret: {token_id}"),
        (["calibration", "withdraw", one], f"would be withdrawn: {one}"),
        (["calibration", "unname", one], f"would lose its name: {one} (it has none)"),
        (["contributor", "forget", contributor], "would be removed: 1 calibrations, 0 sessions, 0 votes"),
        (["reindex"], "tokens to index; 0 calibrations to publish, 0 stale"),
        (["backfill"], "1 modes of cameras would be checked"),
        (["load", tmp_path / "dump"], "6 calibrations and 0 votes would be stored"),
        (["import", guess, *WHOSE], "a first guess"),
        (["seed", rows], "1 rows: 1 first guesses for 1 cameras would be stored"),
    ):
        assert printed in operator(*command, "--dry-run"), command
    operator("calibration", "restore", one, "--dry-run", status=1)
    assert everything(operator) == before


def test_person_is_asked_before_a_token_is_revoked(
    operator: Operator, token_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal("n\n"))
    operator("token", "revoke", token_id, status=1)
    assert token_id in {token["id"] for token in operator.document("token", "list")}


def test_person_is_told_what_forgetting_removes_and_may_say_no(
    operator: Operator, contributor: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = everything(operator)
    monkeypatch.setattr(sys, "stdin", Terminal("n\n"))
    question = operator("contributor", "forget", contributor, status=1)
    assert "Remove 1 calibrations, 0 sessions, 0 votes, 0 rigs for good?" in question
    assert everything(operator) == before


def test_terminal_shows_calibrations_as_a_table(operator: Operator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setenv("DATA_DIR", str(operator.folder))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", screen := Terminal())
        assert main(["camera", "show", KEY]) == 0
    assert "contributor" in screen.getvalue()
    assert "┃" in screen.getvalue()
    assert screen.getvalue().count(f"│ {KEY}-") == 6


def test_plot_draws_members_and_the_one_that_disagrees(operator: Operator) -> None:
    plot = operator("camera", "show", KEY, "--plot").partition("difference from the consensus")
    drawn = plot[0] + plot[2]
    assert "members (5)" in drawn
    assert "alone (1)" in drawn
    assert "fx (px)" in drawn
    assert drawn.count("x") >= 2  # its marker, in the legend and in the picture


def test_each_of_several_files_is_stored_or_refused_by_itself(tmp_path: Path) -> None:
    operator = Operator(tmp_path / "data")
    one, two, bad = (tmp_path / name for name in ("one.yaml", "two.yaml", "bad.yaml"))
    for path in (one, two):
        path.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    bad.write_text("[")
    complaint = operator("import", one, bad, two, *WHOSE, status=1)
    assert f"1 of 3 files could not be used: {bad}" in complaint.splitlines()[-1]
    assert [line.split(": ")[0] for line in operator.printed.splitlines()] == [str(one), str(two)]
    operator("import", one, bad, *WHOSE, "--json", status=1)
    results = json.loads(operator.printed)
    assert [sorted(result) for result in results] == [["file", "result"], ["error", "file"]]


@pytest.mark.parametrize(
    "arguments",
    [[], ["token", "rotate", "x", "--grace", "-1"]],
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
