"""Running sessions: immutable objects `sessions/<sid>/<version>.json`, and an item that names the latest.

Changes follow optimistic concurrency. A change writes its object first and then moves the index to it, on the
condition that the index still names the version that the change was made from. A crash leaves an orphaned
object, never a pointer to nothing. Of two changes at once, one is stored and the other is made anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from calibdb.errors import ConflictError, NotFoundError, UnavailableError
from calibdb.schema import SessionDocument
from calibdb.store.objects import Objects
from calibdb.store.table import IF_NOT_EXISTS, Condition, Item, Table

LIFETIME_S = 24 * 3600  # seconds after its last change; the bucket's rule removes the objects a day later
_SESSIONS_PREFIX = "sessions/"
_ATTEMPTS = 5  # of a change that others keep overtaking
_MAX_ORPHANS = 16  # versions written and never pointed to, one after the other

Result = TypeVar("Result")


@dataclass(frozen=True)
class _Head:
    """Index entry: the latest version, and whether the session was forgotten."""

    version: int
    forgotten: bool


class Sessions:
    """Sessions under their names."""

    def __init__(self, table: Table, objects: Objects) -> None:
        self._table = table
        self._objects = objects

    def find(self, sid: str) -> SessionDocument | None:
        """Return the session as it stands, None when it was not started or was forgotten."""
        found = self._find(sid)
        return found[0] if found else None

    def get(self, sid: str) -> SessionDocument:
        """Return the session as it stands; raises NotFoundError."""
        document = self.find(sid)
        if document is None:
            raise NotFoundError("No session was started under this session id.", kind="no-session")
        return document

    def start(
        self, sid: str, now: int, make: Callable[[int], SessionDocument]
    ) -> tuple[SessionDocument, bool]:
        """Return the running session and False; or store `make(first version)`, and return it and True."""
        for _ in range(_ATTEMPTS):
            head = self._head(sid)
            if head is not None and not head.forgotten:
                found = self._find(sid)
                if found is not None:
                    return found[0], False
                continue  # forgotten in between
            # A session started again under its name goes on counting, so that whoever still works on the
            # forgotten one finds the index moved.
            base = head.version if head else 0
            document = make(base + 1)
            if self._write(sid, base, document, now):
                return document, True
        raise _too_much_contention()

    def update(
        self, sid: str, now: int, change: Callable[[SessionDocument], tuple[SessionDocument | None, Result]]
    ) -> Result:
        """Apply `change` to the session and return its answer; raises NotFoundError.

        `change` returns the new document, or None to leave the session as it is, and an answer. It may be
        called again, with what another request made of the session meanwhile; what it raises leaves
        everything as it is.
        """
        for _ in range(_ATTEMPTS):
            found = self._find(sid)
            if found is None:
                raise NotFoundError("No session was started under this session id.", kind="no-session")
            document, version = found
            changed, answer = change(document)
            if changed is None or self._write(sid, version, changed, now):
                return answer
        raise _too_much_contention()

    def forget(self, sid: str, now: int) -> bool:
        """Forget the session's views; False when there was nothing to forget."""
        for _ in range(_ATTEMPTS):
            head = self._head(sid)
            if head is None or head.forgotten:
                return head is not None
            tombstone = {**_item(sid, head.version + 1, now), "forgotten": 1}
            if self._table.put(tombstone, _if_version(head.version)):
                self._objects.delete([_name(sid, v) for v in range(1, head.version + 1)])
                return True
        raise _too_much_contention()

    def all(self) -> Iterator[SessionDocument]:
        """Yield every session that is not forgotten, as it stands. For operators.

        Where the index says nothing of a session, its highest version counts: whoever writes one in vain
        takes it away again.
        """
        for sid, version in self._versions().items():
            head = self._head(sid)
            if head is None:
                head = _Head(version, forgotten=False)
            content = None if head.forgotten else self._objects.get(_name(sid, head.version))
            if content is not None:
                yield SessionDocument.model_validate_json(content)

    def index(self, now: int) -> int:
        """Let the index name every session in the bucket that it does not know; return how many it did not.

        For operators, who lost the index.
        """
        return sum(
            self._table.put(_item(sid, version, now), IF_NOT_EXISTS)
            for sid, version in self._versions().items()
        )

    def purge(self, sid: str) -> int:
        """Remove all that is stored of the session, for good; return how many objects those were."""
        removed = self._objects.purge_all_versions(list(self._objects.names(f"{_SESSIONS_PREFIX}{sid}/")))
        self._table.delete(f"SESSION#{sid}", "META")
        return removed

    def _versions(self) -> dict[str, int]:
        highest: dict[str, int] = {}
        for name in self._objects.names(_SESSIONS_PREFIX):
            sid, _, file = name.removeprefix(_SESSIONS_PREFIX).partition("/")
            version = file.removesuffix(".json")
            if version.isdecimal():
                highest[sid] = max(highest.get(sid, 0), int(version))
        return highest

    def _find(self, sid: str) -> tuple[SessionDocument, int] | None:
        for _ in range(_ATTEMPTS):
            head = self._head(sid)
            if head is None or head.forgotten:
                return None
            content = self._objects.get(_name(sid, head.version))
            if content is not None:
                return SessionDocument.model_validate_json(content), head.version
            # The index never points to nothing: the session was forgotten between the two reads.
        raise UnavailableError("The session could not be read.")

    def _head(self, sid: str) -> _Head | None:
        item = self._table.get(f"SESSION#{sid}", "META")
        return _Head(int(str(item["version"])), "forgotten" in item) if item else None

    def _write(self, sid: str, base: int, document: SessionDocument, now: int) -> bool:
        content = document.model_dump_json().encode()
        # A taken name is the orphan of a crash, or of someone who is about to overtake us. It cannot be told
        # which, and need not: versions may have gaps, and the index decides.
        for version in range(base + 1, base + 1 + _MAX_ORPHANS):
            if self._objects.create(_name(sid, version), content):
                break
        else:
            raise UnavailableError("The session could not be written.")
        if self._table.put(_item(sid, version, now), _if_version(base) if base else IF_NOT_EXISTS):
            return True
        # A write that was retried because its answer got lost finds itself done: nobody else has this
        # version.
        head = self._head(sid)
        if head == _Head(version, forgotten=False):
            return True
        # Ours counts for nothing: it must not be taken for the session's state when the index is made anew.
        self._objects.delete([_name(sid, version)])
        return False


def _name(sid: str, version: int) -> str:
    return f"{_SESSIONS_PREFIX}{sid}/{version}.json"


def _item(sid: str, version: int, now: int) -> Item:
    return {"pk": f"SESSION#{sid}", "sk": "META", "version": version, "ttl": now + LIFETIME_S}


def _if_version(version: int) -> Condition:
    return Condition("#version = :version", {"version": version}, {"version": "version"})


def _too_much_contention() -> ConflictError:
    return ConflictError("Other requests keep changing this session; send this one again.", kind="overtaken")
