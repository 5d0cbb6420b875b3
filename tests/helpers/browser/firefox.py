"""Firefox, as far as its driver goes: one function in one page."""

from __future__ import annotations

import json
import os
import select
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...browser.conftest import executable
from .waiting import TIMEOUT_S

SCRIPT = Path(__file__).with_name("firefox_evaluate.mjs")


@contextmanager
def screen() -> Iterator[str]:
    """Give the name of a screen that nobody else has; the server itself finds a free one."""
    told, tell = os.pipe()
    command = [
        executable("Xvfb"),
        "-displayfd",
        str(tell),
        "-screen",
        "0",
        "1440x1080x24",
        "-nolisten",
        "tcp",
    ]
    server = subprocess.Popen(command, pass_fds=[tell], stderr=subprocess.DEVNULL)
    os.close(tell)
    try:
        with os.fdopen(told) as answer:
            assert select.select([answer], [], [], TIMEOUT_S)[0], "no screen in time"
            number = answer.readline().strip()
        assert number, "the screen ended as soon as it began"
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


def driven(script: Path, address: str, *, given: str = "", **environment: str) -> Any:
    """Output of a script that drives a page in Firefox; fails if the page complains."""
    command = ["node", str(script), executable("firefox-esr"), address]
    run = subprocess.run(
        command,
        input=given,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=3 * TIMEOUT_S,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    outcome = json.loads(run.stdout)
    assert outcome["complaints"] == []
    return outcome


def in_firefox(address: str, function: str) -> Any:
    """Result of an asynchronous JavaScript function in a page; fails if the page complains."""
    with screen() as name:
        return driven(SCRIPT, address, given=function, DISPLAY=name)["result"]
