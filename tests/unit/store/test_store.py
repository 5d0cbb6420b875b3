"""Storage by its promises: crashes leave orphans, races have one winner, what is published stays."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from calibdb.access.tokens import ApiToken
from calibdb.errors import ConflictError, NotFoundError
from calibdb.rules import session_rules
from calibdb.schema import SessionDocument, SessionRequest
from calibdb.store import Objects, Table, Tokens
from calibdb.store.versions import Sessions
from tests.helpers.service.stores import with_methods

NOW = 1_700_000_000
SID = "6553f1000123456789abcdef"
Change = Callable[[SessionDocument], tuple[SessionDocument, int]]
REQUEST = SessionRequest(camera="Camera", platform="Linux", img_size=(1280, 720))


@pytest.fixture
def sessions(table: Table, objects: Objects) -> Sessions:
    """Sessions, of which one was started."""
    sessions = Sessions(table, objects)
    sessions.start(SID, NOW, begin)
    return sessions


def begin(version: int) -> SessionDocument:
    return session_rules.begin(REQUEST, SID, version, NOW)


def opened(document: SessionDocument) -> tuple[SessionDocument, int]:
    changed = document.model_copy(update={"next_index": document.next_index + 1})
    return changed, changed.next_index


def versions(objects: Objects) -> list[str]:
    return sorted(name.rpartition("/")[2] for name in objects.names(f"sessions/{SID}/"))


def aimed(n: int) -> Change:
    def change(document: SessionDocument) -> tuple[SessionDocument, int]:
        return session_rules.with_target(session_rules.without_target(document), {"n": n}), n

    return change


def test_another_target_writes_no_object(sessions: Sessions, objects: Objects, table: Table) -> None:
    for n in range(12):
        assert sessions.update(SID, NOW, aimed(n)) == n
    document = sessions.get(SID)
    assert document.target == {"n": 11}
    assert [target["n"] for target in document.skipped] == list(range(3, 11))
    assert list(sessions.all()) == [document]
    assert versions(objects) == ["1.json"]
    assert sessions.update(SID, NOW, opened) == 1
    after = sessions.get(SID)
    assert (after.target, after.skipped, after.next_index) == (document.target, document.skipped, 1)
    assert versions(objects) == ["1.json", "14.json"]
    table.delete(f"SESSION#{SID}", "META")
    sessions.index(NOW)
    assert sessions.get(SID) == after
    assert sessions.forget(SID, NOW)
    assert versions(objects) == []


def test_of_a_target_and_a_view_at_once_neither_is_lost(sessions: Sessions) -> None:
    def race(change: Change, other: Change) -> None:
        others = [other]

        def slow(document: SessionDocument) -> tuple[SessionDocument, int]:
            if others:
                sessions.update(SID, NOW, others.pop())
            return change(document)

        sessions.update(SID, NOW, slow)

    race(aimed(7), opened)
    race(opened, aimed(8))
    document = sessions.get(SID)
    assert (document.target, document.next_index) == ({"n": 8}, 2)


def test_session_that_is_deleted_during_a_read_is_missing(
    sessions: Sessions, objects: Objects, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not denied: the roles may list `sessions/`, so S3 says 404 of the object that is gone."""
    get = objects.get

    def late(name: str) -> bytes | None:
        sessions.forget(SID, NOW)
        return get(name)

    monkeypatch.setattr(objects, "get", late)
    assert sessions.find(SID) is None
    with pytest.raises(NotFoundError):
        sessions.get(SID)


def test_orphaned_version_is_skipped(sessions: Sessions, objects: Objects) -> None:
    orphan = begin(1).model_copy(update={"next_index": 77})
    assert objects.create(f"sessions/{SID}/2.json", orphan.model_dump_json().encode())
    assert sessions.get(SID).next_index == 0
    assert sessions.update(SID, NOW, opened) == 1
    assert sessions.get(SID).next_index == 1
    assert sessions.update(SID, NOW, opened) == 2


def test_contended_change_gives_up(sessions: Sessions) -> None:
    def change(document: SessionDocument) -> tuple[SessionDocument, int]:
        sessions.update(SID, NOW, opened)
        return opened(document)

    with pytest.raises(ConflictError):
        sessions.update(SID, NOW, change)


def test_write_with_a_lost_response_is_done(table: Table, objects: Objects) -> None:
    """botocore sends it again, finds its own write there, and the condition false."""

    def put(item: Any, condition: Any = None) -> bool:
        return table.put(item, condition) and table.put(item, condition)

    sessions = Sessions(with_methods(table, put=put), objects)
    sessions.start(SID, NOW, begin)
    assert sessions.update(SID, NOW, opened) == 1
    assert sessions.update(SID, NOW, opened) == 2


def test_concurrent_change_does_not_revive_a_forgotten_session(sessions: Sessions) -> None:
    def change(document: SessionDocument) -> tuple[SessionDocument, int]:
        sessions.forget(SID, NOW)
        return opened(document)

    with pytest.raises(NotFoundError):
        sessions.update(SID, NOW, change)
    assert sessions.find(SID) is None


def test_tokens(table: Table, objects: Objects) -> None:
    tokens = Tokens(table, objects)
    token = ApiToken("id", "hash", ("https://a.example",), "free", NOW)
    assert tokens.get("id") is None
    assert tokens.create(token) is True
    assert tokens.create(token) is False
    assert tokens.get("id") == token
    exchanged = replace(token, secret_sha256="new", former_sha256="hash", former_until=NOW + 9)
    tokens.change(exchanged)
    assert tokens.get("id") == exchanged
    assert list(tokens.all()) == [exchanged]
    tokens.revoke(exchanged, NOW)
    assert tokens.get("id") is None
    assert list(tokens.all()) == []
    assert tokens.create(token) is False  # an id is never another's
    tokens.index(exchanged)  # as if the revocation had been cut short
    assert tokens.reindex() == 0
    assert tokens.get("id") is None
    other = replace(token, id="other")
    tokens.create(other)
    table.delete("TOKEN#other", "META")
    assert tokens.reindex() == 1
    assert tokens.get("other") == other
