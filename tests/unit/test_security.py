"""Links of docs/security.md to the tests that hold its promises."""

import re
from pathlib import Path

from infra.deploy.template import parse

ROOT = Path(__file__).parents[2]


def test_every_linked_test_exists() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", (ROOT / "docs/security.md").read_text())
    assert len(named) > 25
    for path, name in named:
        assert f"\ndef {name}(" in (ROOT / path).read_text(), (path, name)


def test_cors_admits_no_credentials_of_the_browser() -> None:
    api = parse(ROOT / "template.yaml")["Resources"]["HttpApi"]["Properties"]
    assert "AllowCredentials" not in api["CorsConfiguration"]
