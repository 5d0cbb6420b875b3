"""Firefox: pages one after the other, and one function in each."""

import json
import os
import select
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Protocol

import pytest

from .waiting import TIMEOUT_S

Size = tuple[int, int]
SMALL_WINDOW: Size = (800, 600)  # px; the processor draws each of its pixels
SCRIPT = Path(__file__).with_name("firefox_pages.mjs")


class InFirefox(Protocol):
    """Evaluator of asynchronous JavaScript functions in pages; fails if a page logs errors or warnings."""

    def __call__(self, address: str, function: str, before: str = "", size: Size = SMALL_WINDOW) -> Any:
        """Result of a function in the page at an address; the script `before` runs before the page's."""


def executable(name: str) -> str:
    """Path of a program; skips the test if it is not installed."""
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"{name} is not installed")
    return path


@contextmanager
def screen() -> Iterator[str]:
    """Run Xvfb on a free screen in the block; yield its name."""
    told, tell = os.pipe()
    options = f"-displayfd {tell} -screen 0 1440x1080x24 -nolisten tcp"
    command = [executable("Xvfb"), *options.split()]
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


@contextmanager
def firefox() -> Iterator[InFirefox]:
    """Evaluate functions in one Firefox, which starts with the first one."""
    with ExitStack() as stack:
        started: list[subprocess.Popen[str]] = []

        def start() -> subprocess.Popen[str]:
            command = ["node", str(SCRIPT), executable("firefox-esr")]
            environment = os.environ | {"DISPLAY": stack.enter_context(screen())}
            process = subprocess.Popen(
                command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
            stack.enter_context(process)  # closes its input, and waits for its end
            return process

        def evaluate(address: str, function: str, before: str = "", size: Size = SMALL_WINDOW) -> Any:
            if not started:
                started.append(start())
            (process,) = started
            assert process.stdin
            assert process.stdout
            asked = {"address": address, "source": function, "before": before, "size": size}
            process.stdin.write(json.dumps(asked) + "\n")
            process.stdin.flush()
            watchdog = threading.Timer(3 * TIMEOUT_S, process.kill)
            watchdog.start()
            line = process.stdout.readline()
            watchdog.cancel()
            assert line, "Firefox has ended"
            outcome = json.loads(line)
            assert "error" not in outcome, outcome["error"]
            assert outcome["complaints"] == [], outcome["complaints"]
            return outcome["result"]

        yield evaluate
