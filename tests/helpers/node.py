"""JavaScript that tests run under node."""

import json
import subprocess
from typing import Any

from tests.helpers.data import ROOT


def run_module(program: str, *arguments: str, sent: object = None) -> Any:
    """Run an ECMAScript module in the repository with JSON as its input; return the JSON of its last line."""
    done = subprocess.run(
        ["node", "--input-type=module", "-e", program, *arguments],
        input=json.dumps(sent),
        capture_output=True,
        check=False,
        cwd=ROOT,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])
