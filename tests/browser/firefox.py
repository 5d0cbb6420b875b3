"""Firefox, as far as its driver goes: one function in one page."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from .conftest import executable

SCRIPT = Path(__file__).with_name("firefox_evaluate.mjs")


def in_firefox(address: str, function: str) -> Any:
    """What a page makes of an asynchronous JavaScript function; fails where the page complains."""
    # Where xvfb-run begins to look for a free screen: two that look at once would take the same.
    screen = ["-a", "-n", str(100 + os.getpid() % 900)]
    command = [executable("xvfb-run"), *screen, "node", str(SCRIPT), executable("firefox-esr"), address]
    run = subprocess.run(command, input=function, capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stderr
    outcome = json.loads(run.stdout)
    assert outcome["complaints"] == []
    return outcome["result"]
