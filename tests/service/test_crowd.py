"""Many clients over failing connections: every acknowledged view is stored, once (`make bench DOCS=load`)."""

from pathlib import Path

import pytest

from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.bench.captures import drive, main
from tests.bench.crowd import missing_or_double

JOBS = False


def test_acknowledged_views_are_stored_once(tmp_path: Path) -> None:
    with Server(tmp_path / "data") as stack, stack.serve() as url:
        # Most captures end after a view: what goes wrong goes wrong in single requests.
        outcome = drive(url, DEVELOPMENT_TOKEN, sessions=10, clients=10, cameras=2, finished=0.2, seed=2)
        stack.wait_until_idle(60)
    finished = [one for one in outcome.heard if one.calibration_id]
    assert len(outcome.heard) == 10
    assert 1 <= len(finished) <= 4
    for fault in ("cut off", "unheard", "twice"):
        assert outcome.counts[fault] > 0.04 * outcome.counts["requests"]
    assert missing_or_double(tmp_path / "data", outcome.heard) == []


def test_any_stack_can_be_driven(stack: Server, capsys: pytest.CaptureFixture[str]) -> None:
    with stack.serve() as url:
        assert main([url, "--sessions", "1", "--clients", "1"]) == 0
        assert "1 captures in" in capsys.readouterr().out
        assert main([url, "--token", "cdb_no_token", "--sessions", "1"]) == 1
        assert "403" in capsys.readouterr().err
