"""Curl alone goes from nothing to a calibration, by the lines of the API's page, too."""

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from infra.server.server import Server
from tests.helpers.service import published

DOCUMENT = (Path(__file__).parents[3] / "docs/api.md").read_text()
LABEL = "HD Pro Webcam C920 (046d:082d)"


def block(heading: str) -> str:
    """Return the first block of shell code below a heading."""
    found = re.search(rf"^#+ {re.escape(heading)}\n.*?```sh\n(.*?)```", DOCUMENT, re.DOTALL | re.MULTILINE)
    assert found, heading
    return found[1]


def test_documented_curl_goes_from_nothing_to_a_calibration() -> None:
    with Server() as stack, stack.serve() as url:
        published.publish(stack, *(published.calibration(LABEL, n) for n in range(5)))
        opening = block("The HTTP API").replace("http://127.0.0.1:8000", url)
        assert opening.splitlines()[0] == f"API={url}/v1"

        def run(lines: str, token: str = "") -> Any:
            script = "\n".join([opening, *([f"TOKEN={token}"] if token else []), lines])
            command = ["bash", "-ec", script]
            sent = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
            return json.loads(sent.stdout)

        made = run(block("Make a token"))
        assert [origin["state"] for origin in made["origins"]] == ["verified", "pending"]
        found = run(block("Look a camera up"), made["token"])
        assert found["reliable"], found
        assert found["camera_matrix"][0][0] == pytest.approx(950, rel=0.02)
        used = run('curl -s $API/usage -H "Authorization: Bearer $TOKEN"', made["token"])
        assert used["used"]["lookups"] == 2
        managed = run(f'curl -s $API/tokens/self -H "Authorization: Bearer {made["management_token"]}"')
        assert sum(day["lookups"] for day in managed["use"]["days"]) == 2
