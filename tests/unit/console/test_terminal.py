"""Output on a terminal, in a pipe and for programs; progress; questions; announced steps."""

import io
import json
import sys
from pathlib import Path

import pytest
import typer

from infra.console import Output, announce, confirm, format_duration, track
from tests.helpers.clock import Clock
from tests.helpers.service.commands import Terminal


def write(as_json: bool) -> None:
    output = Output(as_json=as_json)
    output.line("two cameras")
    output.table(("camera", "#calibrations"), [("[red]c920[/red]", 5)], ["c920  5 calibrations"])
    output.value([{"key": "c920"}])
    output.finish()


def test_terminal_gets_a_table_without_markup(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", screen := Terminal())
    write(as_json=False)
    assert "two cameras" in screen.getvalue()
    assert "[red]c920[/red]" in screen.getvalue()
    assert "┃" in screen.getvalue()
    assert "5 calibrations" not in screen.getvalue()


def test_pipe_gets_lines(capsys: pytest.CaptureFixture[str]) -> None:
    write(as_json=False)
    assert capsys.readouterr().out == "two cameras\nc920  5 calibrations\n"


def test_program_gets_one_document_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    write(as_json=True)
    assert json.loads(capsys.readouterr().out) == [{"key": "c920"}]


def test_progress_shows_number_and_time_left_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", screen := Terminal())
    monkeypatch.setenv("COLUMNS", "100")
    assert list(track(range(3), "captures", lambda: 3)) == [0, 1, 2]
    assert "captures" in screen.getvalue()
    assert "/3" in screen.getvalue()
    assert "left" in screen.getvalue()


def test_progress_is_silent_in_a_pipe_and_counts_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    def count() -> int:
        raise AssertionError("counting costs requests")

    assert list(track("abc", "letters", count)) == ["a", "b", "c"]
    assert capsys.readouterr() == ("", "")


def test_person_is_asked_and_a_program_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal("n\n"))
    with pytest.raises(typer.Abort):
        confirm("Remove it for good?", yes=False)
    monkeypatch.setattr(sys, "stdin", Terminal("y\n"))
    confirm("Remove it for good?", yes=False)
    confirm("Remove it for good?", yes=True)
    monkeypatch.setattr(sys, "stdin", io.StringIO("n\n"))
    confirm("Remove it for good?", yes=False)


def run(path: Path, steps: list[str], durations: list[float]) -> list[str]:
    """Run steps that take so long; return what was said."""
    said: list[str] = []
    clock = Clock()
    for step in announce("work", steps, str, say=said.append, clock=clock, path=path):
        clock.now += durations[steps.index(step)]
    return said


def test_later_run_tells_the_time_left(tmp_path: Path) -> None:
    path = tmp_path / "new" / "d.json"
    assert run(path, ["build", "upload"], [30, 10]) == ["1/2 build", "2/2 upload"]
    assert run(path, ["build", "upload"], [30, 10]) == ["1/2 build (40 s left)", "2/2 upload (10 s left)"]
    assert run(path, ["build", "smoke"], [30, 1])[0] == "1/2 build (more than 30 s left)"


def test_failed_step_is_not_remembered_and_others_are(tmp_path: Path) -> None:
    path = tmp_path / "d.json"
    clock = Clock()
    for step in announce("work", ["a", "b"], str, say=lambda _: None, clock=clock, path=path):
        clock.now += 5
        if step == "b":
            break
    assert json.loads(path.read_text()) == {"work: a": 5.0}


def test_damaged_file_of_durations_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "d.json"
    for content in ("{", "[]", '{"work: a": "b"}'):
        path.write_text(content)
        assert run(path, ["a"], [2]) == ["1/1 a"], content
        assert json.loads(path.read_text()) == {"work: a": 2.0}


def test_durations_read_as_people_say_them() -> None:
    assert [format_duration(s) for s in (0.2, 89, 100, 3700)] == ["1 s", "89 s", "2 min", "1 h 2 min"]
