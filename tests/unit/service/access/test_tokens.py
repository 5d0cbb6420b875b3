"""Credentials: what opens what, for how long, and through a change of keys."""

import pytest

from calibdb.access.tokens import (
    ApiToken,
    SessionIds,
    Ticket,
    contributor,
    matches,
    parse,
    secret_hash,
    source,
)
from calibdb.errors import ForbiddenError
from tests.helpers.clock import Clock

OLD, NEW = "old secret " * 4, "new secret " * 4
TICKET = Ticket("6b0113478f87f366bd2f0a11", "dev")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("cdb_dev_local", ("dev", "local")),
        ("cdb_a-1_s_e-c_", ("a-1", "s_e-c_")),
        ("cdb_dev_", None),
        ("cdb__local", None),
        ("dev_local", None),
        ("cdb_dev_local\n", None),
        ("cdb_d\u00e9v_local", None),
        ("cdb_" + "a" * 65 + "_x", None),
        ("", None),
    ],
)
def test_token_text_is_parsed(text: str, parts: tuple[str, str] | None) -> None:
    assert parse(text) == parts


def test_a_token_is_its_hash() -> None:
    token = ApiToken("dev", "25bf8e1a2393f1108d37029b3df5593236c755742ec93465bbafa9b290bddcf6")
    assert secret_hash("local") == token.secret_sha256  # sha256sum of "local"
    assert matches(token, "local")
    assert not matches(token, "Local")
    assert not matches(token, "")


@pytest.mark.parametrize(
    ("origins", "origin", "admitted"),
    [
        ((), "https://a.example", True),
        (("https://a.example",), "https://a.example", True),
        (("https://a.example",), "https://a.example.evil", False),
        (("https://a.example",), "http://a.example", False),
        (("https://a.example",), "null", False),
        (("https://a.example",), None, True),
        (("http://localhost",), "http://localhost:5173", True),
        (("http://127.0.0.1:8000",), "http://127.0.0.1:8000", True),
        (("http://127.0.0.1:8000",), "http://127.0.0.1", False),
        (("https://app.localhost",), "https://app.localhost:8443", True),
    ],
)
def test_origins(origins: tuple[str, ...], origin: str | None, admitted: bool) -> None:
    assert ApiToken("t", "", origins).admits(origin) is admitted


def test_secrets_are_exchanged_while_sessions_run() -> None:
    clock = Clock()
    before = SessionIds([OLD], clock)
    during = SessionIds([NEW, OLD], clock)
    after = SessionIds([NEW], clock)
    issued_before, _ = before.issue(TICKET)
    issued_during, _ = during.issue(TICKET)
    assert during.verify(issued_before, None) == TICKET
    assert after.verify(issued_during, None) == TICKET  # the newest key signs
    for ids, session_id in ((after, issued_before), (before, issued_during)):
        with pytest.raises(ForbiddenError):
            ids.verify(session_id, None)


def test_changed_session_id_is_refused() -> None:
    ids = SessionIds([NEW], Clock())
    session_id, _ = ids.issue(TICKET)
    for place, character in enumerate(session_id[:-1]):  # of the last one only some bits count
        forged = session_id[:place] + ("A" if character != "A" else "B") + session_id[place + 1 :]
        with pytest.raises(ForbiddenError):
            ids.verify(forged, None)


def test_contributors_and_sources_are_keyed_hashes() -> None:
    address = "192.0.2.7"
    hashes = {
        contributor("key", address, "dev"),
        contributor("another key", address, "dev"),
        contributor("key", "192.0.2.8", "dev"),
        contributor("key", address, "other"),
        contributor("key", address, ""),
        source("key", address),
        source("another key", address),
    }
    assert [len(one) for one in hashes] == [64] * 7
    assert contributor("key", address, "dev") in hashes


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("192.0.2.7", "192.0.2.7", True),
        ("192.0.2.7", "192.0.2.8", False),
        ("192.0.2.7", "::ffff:192.0.2.7", True),
        ("2001:db8:1:2::1", "2001:db8:1:ffff::9", True),  # one site
        ("2001:db8:1:2::1", "2001:db8:2:2::1", False),
    ],
)
def test_a_source_is_an_address_or_a_site(one: str, other: str, *, same: bool) -> None:
    assert (source("key", one) == source("key", other)) is same
    assert source("key", other).startswith("v6-") == other.startswith("2001:"), "votes count one family"
