"""Output on a terminal, in a pipe and for programs; progress; questions."""

import io
import json
import sys

import pytest
import typer

from infra.console import Output, confirm, track


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


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
