"""Running documents: immutable objects `<prefix><name>/<version>.json`, and an item that names the latest.

A change of a few small members (`Versions.small`) writes no object: the item has them, next to the version
whose object has the others.

A change writes its object first and then moves the index to it, on the condition that the index still names
the version that the change was made from. A crash leaves an orphaned object, never a pointer to nothing.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from pydantic import BaseModel

from calibdb.errors import ConflictError, NotFoundError, UnavailableError
from calibdb.schema import SessionDocument
from calibdb.store.ports import IF_NOT_EXISTS, DocumentStore, Item, Value, encoded, equals

LIFETIME_S = 24 * 3600  # seconds after its last change; the bucket's rule removes the objects a day later
_MAX_UPDATE_ATTEMPTS = 5  # of a change that others keep overtaking
_MAX_ORPHANS = 16  # versions written and never pointed to, one after the other
_SK = "META"

Document = TypeVar("Document", bound=BaseModel)
Result = TypeVar("Result")


@dataclass(frozen=True)
class Head:
    """Index entry of a document."""

    version: int
    content: int  # version whose object has the document, except for the members in `small`
    forgotten: bool = False
    small: str = ""  # members that changed since, as JSON
    facts: Item = field(default_factory=dict)  # all attributes of the item


class Versions(DocumentStore, Generic[Document]):
    """Documents of one kind under their names."""

    model: type[Document]
    prefix: str  # of the names of objects
    partition: str  # prefix of the partitions of items
    noun: str  # in messages
    missing: str  # detail of the problem if there is none
    missing_kind: str
    small: tuple[str, ...] = ()  # members that change without the others, and then are stored in the item

    def facts(self, document: Document) -> Mapping[str, Value]:  # noqa: ARG002
        """Attributes of the item besides the version, which follow from the document."""
        return {}

    def find(self, name: str) -> Document | None:
        """Document as it stands, None if there was none or it was forgotten."""
        version = self.find_version(name)
        return version[0] if version else None

    def get(self, name: str) -> Document:
        """Document as it stands; raises NotFoundError."""
        return self.get_version(name)[0]

    def find_version(self, name: str) -> tuple[Document, int] | None:
        """Document as it stands and its version; None as `find`."""
        for _ in range(_MAX_UPDATE_ATTEMPTS):
            head = self.head(name)
            if head is None or head.forgotten:
                return None
            content = self._objects.get(self._object(name, head.content))
            if content is not None:
                return self._parse(content, head.small), head.version
            # The index never points to nothing: it was forgotten between the two reads.
        raise UnavailableError(f"The {self.noun} could not be read.")

    def get_version(self, name: str) -> tuple[Document, int]:
        """Document as it stands and its version; raises NotFoundError."""
        version = self.find_version(name)
        if version is None:
            raise NotFoundError(self.missing, kind=self.missing_kind)
        return version

    def head(self, name: str) -> Head | None:
        """Index entry, None if the document never was."""
        item = self._table.get(self._pk(name), _SK)
        if item is None:
            return None
        version: int = item["version"]
        content = item.get("content", version)
        return Head(version, content, "forgotten" in item, item.get("small", ""), item)

    def start(self, name: str, now: int, make: Callable[[int], Document]) -> tuple[Document, bool]:
        """Return the running document and False; or store `make(first version)`, and return it and True."""
        for _ in range(_MAX_UPDATE_ATTEMPTS):
            head = self.head(name)
            if head is not None and not head.forgotten:
                running = self.find(name)
                if running is not None:
                    return running, False
                continue  # forgotten in between
            # A session restarted under its name continues the count, so that code working on the deleted
            # one finds the index moved.
            base = head.version if head else 0
            document = make(base + 1)
            if self._write(name, base, document, now):
                return document, True
        raise self._too_much_contention()

    def update(
        self, name: str, now: int, change: Callable[[Document], tuple[Document | None, Result]]
    ) -> Result:
        """Apply `change` to the document and return its result; raises NotFoundError.

        `change` returns the new document, or None to leave it as it is, and a result. If another request was
        faster, it is called again. What it raises leaves everything as it is.
        """
        for _ in range(_MAX_UPDATE_ATTEMPTS):
            document, version = self.get_version(name)
            changed, result = change(document)
            if changed is None:
                return result
            write = self._write_small if self._is_small(document, changed) else self._write
            if write(name, version, changed, now):
                return result
        raise self._too_much_contention()

    def revise(self, name: str, now: int, change: Callable[[Document], Document | None]) -> Document:
        """Apply `change`, which returns None to leave the document, as `update` does; return the document."""

        def with_document(document: Document) -> tuple[Document | None, Document]:
            changed = change(document)
            return changed, changed or document

        return self.update(name, now, with_document)

    def forget(self, name: str, now: int) -> bool:
        """Forget the document; False if there was nothing to forget."""
        for _ in range(_MAX_UPDATE_ATTEMPTS):
            head = self.head(name)
            if head is None or head.forgotten:
                return head is not None
            tombstone = {**self._item(name, head.version + 1, now), "forgotten": 1}
            if self._table.put(tombstone, equals(version=head.version)):
                self._objects.delete([self._object(name, v) for v in range(1, head.version + 1)])
                return True
        raise self._too_much_contention()

    def all(self) -> Iterator[Document]:
        """Yield every document that is not forgotten, in its highest version if it is not indexed."""
        for name, version in self._versions().items():
            head = self.head(name) or Head(version, version)
            content = None if head.forgotten else self._objects.get(self._object(name, head.content))
            if content is not None:
                yield self._parse(content, head.small)

    def index(self, now: int) -> int:
        """Index every document in the bucket that the index lacks; return their number."""
        added = 0
        for name, version in self._versions().items():
            content = None if self.head(name) else self._objects.get(self._object(name, version))
            if content is not None:
                facts = self.facts(self._parse(content))
                added += self._table.put({**self._item(name, version, now), **facts}, IF_NOT_EXISTS)
        return added

    def purge(self, name: str) -> None:
        """Remove all that is stored of the document, for good."""
        self._objects.purge_all_versions(list(self._objects.names(f"{self.prefix}{name}/")))
        self._table.delete(self._pk(name), _SK)

    def _versions(self) -> dict[str, int]:
        highest: dict[str, int] = {}
        for path in self._objects.names(self.prefix):
            name, _, file = path.removeprefix(self.prefix).partition("/")
            version = file.removesuffix(".json")
            if version.isdecimal():
                highest[name] = max(highest.get(name, 0), int(version))
        return highest

    def _write(self, name: str, base: int, document: Document, now: int) -> bool:
        # A taken name is the orphan of a crash, or of a writer that is about to overtake this one. Both are
        # skipped: versions may have gaps, and the index decides.
        for version in range(base + 1, base + 1 + _MAX_ORPHANS):
            if self._objects.create(self._object(name, version), encoded(document)):
                break
        else:
            raise UnavailableError(f"The {self.noun} could not be written.")
        item = {**self._item(name, version, now), **self.facts(document)}
        if self._table.put(item, equals(version=base) if base else IF_NOT_EXISTS):
            return True
        # A write that was retried because its response got lost is done: no other has this object.
        head = self.head(name)
        if head is not None and (head.version, head.content, head.forgotten) == (version, version, False):
            return True
        # This object is obsolete: a rebuild of the index must not take it for the document's state.
        self._objects.delete([self._object(name, version)])
        return False

    def _is_small(self, document: Document, changed: Document) -> bool:
        members = set(type(document).model_fields) - set(self.small)
        return bool(self.small) and all(getattr(document, m) == getattr(changed, m) for m in members)

    def _write_small(self, name: str, base: int, document: Document, now: int) -> bool:
        head = self.head(name)
        if head is None or head.version != base:
            return False
        small = document.model_dump_json(include=set(self.small))
        item = {**self._item(name, base + 1, now), **self.facts(document)}
        if self._table.put(item | {"content": head.content, "small": small}, equals(version=base)):
            return True
        head = self.head(name)  # of a write that was retried because its response got lost
        return head is not None and (head.version, head.small) == (base + 1, small)

    def _parse(self, content: bytes, small: str = "") -> Document:
        if small:
            content = json.dumps({**json.loads(content), **json.loads(small)}).encode()
        return self.model.model_validate_json(content)

    def _object(self, name: str, version: int) -> str:
        return f"{self.prefix}{name}/{version}.json"

    def _pk(self, name: str) -> str:
        return f"{self.partition}{name}"

    def _item(self, name: str, version: int, now: int) -> Item:
        return {"pk": self._pk(name), "sk": _SK, "version": version, "ttl": now + LIFETIME_S}

    def _too_much_contention(self) -> ConflictError:
        return ConflictError(
            f"Other requests keep changing this {self.noun}; send this one again.", kind="overtaken"
        )


class Sessions(Versions[SessionDocument]):
    """Sessions under their names. Their views are up to a megabyte, so that `small` members matter."""

    model = SessionDocument
    prefix = "sessions/"
    partition = "SESSION#"
    noun = "session"
    missing = "No session was started under this session id."
    missing_kind = "no-session"
    small = ("target", "skipped", "duplicates")
