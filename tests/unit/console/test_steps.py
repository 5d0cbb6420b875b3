"""Steps of a long piece of work: what is said before each, and what is remembered."""

import json
from pathlib import Path

from infra.console import announce, format_duration
from tests.helpers.clock import Clock


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


def test_unknown_step_makes_the_time_a_lower_bound(tmp_path: Path) -> None:
    path = tmp_path / "d.json"
    run(path, ["build"], [200])
    assert run(path, ["build", "smoke"], [200, 1])[0] == "1/2 build (more than 3 min left)"


def test_failed_step_is_not_remembered_and_others_are(tmp_path: Path) -> None:
    path = tmp_path / "d.json"
    clock = Clock()
    for step in announce("work", ["a", "b"], str, say=lambda _: None, clock=clock, path=path):
        clock.now += 5
        if step == "b":
            break
    assert json.loads(path.read_text()) == {"work": {"a": 5.0}}


def test_damaged_file_of_durations_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "d.json"
    for content in ("{", "[]", '{"work": 3}', '{"work": {"a": "b"}}'):
        path.write_text(content)
        assert run(path, ["a"], [2]) == ["1/1 a"], content
        assert json.loads(path.read_text()) == {"work": {"a": 2.0}}


def test_durations_read_as_people_say_them() -> None:
    assert [format_duration(s) for s in (0.2, 40, 89, 100, 3700)] == [
        "1 s",
        "40 s",
        "89 s",
        "2 min",
        "1 h 2 min",
    ]
