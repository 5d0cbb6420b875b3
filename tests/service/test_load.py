"""The command that loads a deployment."""

from tests.bench.captures import main
from tests.helpers.service.commands import run

JOBS = False


def test_any_stack_can_be_driven(url: str) -> None:
    assert "1 captures in" in run(main, url, "--sessions", "1", "--clients", "1").out
    assert "403" in run(main, url, "--token", "cdb_no_token", "--sessions", "1", status=1).err
