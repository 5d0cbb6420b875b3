"""Links of docs/security.md to the tests that hold its promises."""

import gzip
import json
import re
from pathlib import Path

from infra.deploy.template import parse
from infra.server.server import Server
from tests.helpers.service.client import TOKEN, Client

ROOT = Path(__file__).parents[2]


def test_every_linked_test_exists() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", (ROOT / "docs/security.md").read_text())
    assert len(named) > 25
    for path, name in named:
        assert f"\ndef {name}(" in (ROOT / path).read_text(), (path, name)


def test_a_compressed_body_is_never_unpacked() -> None:
    bomb = gzip.compress(b" " * 5_000_000 + json.dumps({"camera": "x"}).encode())
    assert len(bomb) < 10_000
    with Server() as stack:
        client = Client(stack)
        for encoding in ("gzip", "deflate", "br", "identity"):
            headers = {"content-encoding": encoding}
            answer = client.call("POST", "/v1/lookup", bomb, token=TOKEN, headers=headers)
            assert answer.status == 400, answer


def test_cors_admits_no_credentials_of_the_browser() -> None:
    api = parse(ROOT / "template.yaml")["Resources"]["HttpApi"]["Properties"]
    assert "AllowCredentials" not in api["CorsConfiguration"]
