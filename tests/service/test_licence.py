"""The licence of what a contributor gives."""

from typing import Any

import pytest

from calibdb.dump.public_copy import public_copy
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.published import store

JOBS = False

CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


@pytest.mark.parametrize(
    ("said", "field"),
    [
        ({"licence": "MIT"}, "licence"),
        ({"licence": "CC0-1.0", "licence_version": "2026-13-01"}, "licence_version"),
        ({"licence": "CC0-1.0", "licence_version": "2026-W47-7"}, "licence_version"),
        ({"licence_version": "2026-11-22"}, "licence_version"),
    ],
)
def test_consent_to_something_else_is_refused(client: Client, said: dict[str, Any], field: str) -> None:
    assert client.open(**said).fields == [field]


def test_licence_is_stored_with_session_calibration_and_export(client: Client) -> None:
    ended = Truth(seed=3).calibrate(client, camera="Licensed Z1", **BRIEF, **CONSENT)
    (session,) = (each for each in store(client.stack).sessions.all() if each.camera == "Licensed Z1")
    stored = store(client.stack).calibrations.get(ended["calibration_id"])
    assert session.consent == stored.consent == CONSENT
    assert consent(ended) == consent(client.calibration(stored.id).json) == CONSENT


def consent(of: Any) -> dict[str, Any]:
    return {name: of[name] for name in CONSENT}


def test_licence_is_added_to_a_published_calibration_once(client: Client) -> None:
    ended = Truth(seed=3).calibrate(client, camera="Licensed Z2", **BRIEF)
    calibrations = store(client.stack).calibrations
    before = calibrations.get(ended["calibration_id"])
    assert public_copy(before, lambda text: text) is None, "dumps have none of it"
    assert client.call("POST", "/v1/session/licence", {"licence_version": "2026-11-22"}).status == 422
    # A later text is another agreement, which this session has no place for.
    for version in ("2026-11-22", "2026-12-01"):
        licensed = client.call("POST", "/v1/session/licence", CONSENT | {"licence_version": version})
        assert consent(licensed.json) == CONSENT
    after = calibrations.get(before.id)
    assert after == before.model_copy(update=CONSENT)
    assert public_copy(after, lambda text: text) is not None
    assert calibrations.licence(before.camera_key) == "CC0-1.0"
    assert client.state()["calibration"] == ended["calibration"]


def test_licence_is_added_to_a_session_before_it_ends(running: Client) -> None:
    running.call("POST", "/v1/session/licence", CONSENT)
    assert consent(running.state()) == CONSENT
