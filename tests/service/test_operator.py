"""The local stack says who runs it, as it was told by its environment."""

import httpx
import pytest

from infra.server.server import Server

OPERATOR = {
    "OPERATOR_NAME": "Lens Society",
    "OPERATOR_CONTACT": "mailto:lens@society.example",
    "IMPRINT": "Lens Society|1 Optics Road|Exampletown",
}


def test_settings_and_security_file_say_who_runs_the_service(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in OPERATOR.items():
        monkeypatch.setenv(name, value)
    with Server() as stack, stack.serve() as url, httpx.Client(base_url=url, timeout=60) as site:
        told = site.get("/config.json").json()["operator"]
        security = site.get("/.well-known/security.txt").text
    assert told == {
        "name": OPERATOR["OPERATOR_NAME"],
        "contact": OPERATOR["OPERATOR_CONTACT"],
        "imprint": OPERATOR["IMPRINT"],
    }
    assert f"Contact: {OPERATOR['OPERATOR_CONTACT']}" in security
