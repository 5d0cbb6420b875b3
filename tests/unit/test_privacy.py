"""The privacy notice says what the code does: stored fields, keys in browsers, times of the template."""

import json
import re
from typing import Any

import pytest

from calibdb.access.tokens import SessionIds, Ticket
from calibdb.schema import (
    CalibrationDocument,
    RigCalibrationDocument,
    RigDocument,
    SessionDocument,
    VoteDocument,
)
from calibdb.schema.session import Track
from tests.helpers.data import ROOT
from tests.helpers.sam import resources

NOTICE = (ROOT / "web/privacy/index.html").read_text("utf-8")
TEXTS: dict[str, str] = json.loads((ROOT / "web/messages/en/privacy.json").read_text("utf-8"))
TERMS = (ROOT / "web/terms/index.html").read_text("utf-8")
SCRIPTS = {
    path: path.read_text("utf-8")
    for path in (ROOT / "web").rglob("*.js")
    if "vendor" not in path.parts and "messages" not in path.parts
}


def row(name: str) -> str:
    """Read from the notice for how long something is kept."""
    found = re.search(rf'data-t="privacy.row_{name}".*?</th><td[^>]* data-t="privacy.(\w+)">', NOTICE)
    assert found is not None, name
    return TEXTS[found[1]]


@pytest.mark.parametrize(
    ("document", "model"),
    [
        ("session", SessionDocument),
        ("calibration", CalibrationDocument),
        ("rig", RigDocument),
        ("rig calibration", RigCalibrationDocument),
        ("check", VoteDocument),
        ("track", Track),
    ],
)
def test_every_stored_field_is_named(document: str, model: Any) -> None:
    listed = re.search(rf'data-document="{document}">(.*?)</dd>', NOTICE)
    named = set(re.findall(r"<code>(\w+)</code>", listed[1]))
    assert named == set(model.model_fields) - {"layout"}


def test_every_key_in_the_browsers_storage_is_named() -> None:
    """Keys begin with `calibdb.`, so that they are found here and on the page."""
    used = set()
    for path, script in SCRIPTS.items():
        if path.name == "storage.js" or not re.search(r"localStorage|/storage\.js", script):
            continue
        keys = set(re.findall(r'"(calibdb\.[\w.-]+)"', script))
        assert keys, f"{path} uses the storage under a key that is not written out"
        used |= keys
    assert set(re.findall(r"<code>(calibdb\.[\w.-]+)</code>", NOTICE)) == used
    named = (re.findall(r'const (?:DATABASE|CACHE) = "(\w+)"', script) for script in SCRIPTS.values())
    databases = {name for names in named for name in names}
    assert databases == {"calibdb"}


def test_times_are_those_of_the_template() -> None:
    logs = [r["Properties"] for r in resources().values() if r["Type"] == "AWS::Logs::LogGroup"]
    assert {log["RetentionInDays"] for log in logs} == {30}
    assert row("logs") == "30 days"
    lifecycle = resources()["KeypointBucket"]["Properties"]["LifecycleConfiguration"]
    rules = {r["Id"]: r for r in lifecycle["Rules"]}
    sessions = rules["ForgetSessions"]
    assert (sessions["ExpirationInDays"], sessions["NoncurrentVersionExpiration"]["NoncurrentDays"]) == (2, 1)
    assert row("capture") == "2 days; deleted versions another day"
    recovery = resources()["Table"]["Properties"]["PointInTimeRecoverySpecification"]
    assert recovery == {"PointInTimeRecoveryEnabled": True}  # 35 days unless told otherwise
    assert any("a backup of 35 days" in text for text in TEXTS.values())


def test_pages_agree_on_the_text_of_the_licence() -> None:
    script = (ROOT / "web/lib/consent.js").read_text("utf-8")
    found = re.search(r'LICENCE_VERSION = "([\d-]+)"', script)
    assert f"<code>{found[1]}</code>" in TERMS


def test_receipt_names_its_session_and_no_other() -> None:
    """The session id proves who made the calibration; a forged one names nothing."""
    ids = SessionIds(("new", "old"), lambda: 1_000_000.0)
    receipt, _ = SessionIds(("old",), lambda: 0.0).issue(Ticket("65543210aaaaaaaaaaaaaaaa", "token"))
    assert ids.sid_of(receipt) == "65543210aaaaaaaaaaaaaaaa", "long expired, and signed by the key before"
    forged, _ = SessionIds(("else",), lambda: 0.0).issue(Ticket("65543210aaaaaaaaaaaaaaaa", "token"))
    for text in (forged, receipt[:-1], receipt + "x", "", "." * 5000):
        assert ids.sid_of(text) is None
