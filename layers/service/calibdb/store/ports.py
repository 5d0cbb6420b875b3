"""Ports of storage: `Table`, `Objects` and `Jobs`, implemented for AWS (`aws`) and SQLite (`sqlite`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeVar

from pydantic import BaseModel

Document = TypeVar("Document", bound=BaseModel)
Value = str | int | list[str]
Item = dict[str, Any]
"""Attributes by name, each a `Value`."""
Relation = Literal["absent", "=", "<", "<="]
JobName = Literal["refit", "verify", "dump"]

READERS = 8  # threads that read objects at a time


@dataclass(frozen=True)
class Comparison:
    """Comparison of one attribute of the stored item.

    `absent` ignores `value`. An attribute that is absent satisfies no other relation.
    """

    name: str
    relation: Relation
    value: Value = ""

    def holds(self, item: Item | None) -> bool:
        """True if the stored item satisfies the comparison; None: there is no item."""
        stored = None if item is None else item.get(self.name)
        if self.relation == "absent":
            return stored is None
        if self.relation == "=":
            return bool(stored == self.value)
        if not isinstance(stored, int) or not isinstance(self.value, int):
            return False
        return stored < self.value if self.relation == "<" else stored <= self.value


@dataclass(frozen=True)
class Condition:
    """Condition on the stored item of a write: all comparisons of at least one of `alternatives` hold."""

    alternatives: tuple[tuple[Comparison, ...], ...]

    def __or__(self, other: Condition) -> Condition:
        return Condition(self.alternatives + other.alternatives)

    def holds(self, item: Item | None) -> bool:
        """True if the stored item satisfies the condition; None: there is no item."""
        return any(all(each.holds(item) for each in together) for together in self.alternatives)


def compared(name: str, relation: Relation, value: Value = "") -> Condition:
    """Condition on one attribute."""
    return Condition(((Comparison(name, relation, value),),))


def equals(**values: Value) -> Condition:
    """Condition that these attributes have these values."""
    return Condition((tuple(Comparison(name, "=", value) for name, value in values.items()),))


IF_NOT_EXISTS = compared("pk", "absent")


class Table(Protocol):
    """Reads and conditional writes of single items under `pk` and `sk`. Numbers are integers."""

    def get(self, pk: str, sk: str, *, consistent: bool = True) -> Item | None:
        """Item."""
        ...

    def put(self, item: Item, condition: Condition | None = None) -> bool:
        """Write the item; False, and nothing written, if `condition` does not hold."""
        ...

    def put_transaction(self, items: Sequence[Item], condition: Condition) -> bool:
        """Write all items or none; False, and nothing written, if `condition` does not hold of the first.

        One of two concurrent writers gets False.
        """
        ...

    def add(
        self, pk: str, sk: str, name: str, amount: int, *, limit: int | None = None, ttl: int | None = None
    ) -> int | None:
        """Add to the counter `name` of an item, creating both if necessary; return the new value.

        None, and nothing added, if the value would exceed `limit`. A retried addition may count twice.
        """
        ...

    def remove(self, pk: str, sk: str, name: str) -> None:
        """Remove the attribute `name` of an item, if the item exists."""
        ...

    def delete(self, pk: str, sk: str, condition: Condition | None = None) -> bool:
        """Delete the item, if it exists; False, and nothing deleted, if `condition` does not hold."""
        ...

    def query(
        self,
        pk: str,
        prefix: str,
        *,
        newest_first: bool = False,
        limit: int | None = None,
        consistent: bool = False,
        after: str | None = None,
    ) -> list[Item]:
        """Items of `pk` whose `sk` begins with `prefix`, by `sk`; `after`: those that follow this `sk`."""
        ...

    def keys(self, pk_prefix: str) -> Iterator[tuple[str, str]]:
        """Yield the keys of all items whose `pk` begins with `pk_prefix`: a scan, for operators."""
        ...


class Objects(Protocol):
    """Objects under names. Reads raise DeniedReadError."""

    def get(self, name: str) -> bytes | None:
        """Object's content."""
        version = self.get_version(name)
        return None if version is None else version[0]

    def get_version(self, name: str) -> tuple[bytes, str] | None:
        """Object's content and the tag of this version."""
        ...

    def replace(self, name: str, content: bytes, tag: str) -> bool:
        """Write the object over the version with this tag; False, and nothing written, over another."""
        ...

    def create(self, name: str, content: bytes) -> bool:
        """Write a new object; False, and nothing written, if the name is taken."""
        ...

    def put(self, name: str, content: bytes, media_type: str = ..., cache_control: str | None = None) -> None:
        """Write the object, replacing the one with its name."""
        ...

    def purge_all_versions(self, names: Iterable[str]) -> int:
        """Remove the objects with every stored version; return the number of versions."""
        ...

    def delete(self, names: Sequence[str]) -> None:
        """Delete the objects that exist."""
        ...

    def names(self, prefix: str, after: str = "") -> Iterator[str]:
        """Yield the names that begin with `prefix` and come after `after`, in order."""
        ...


class ItemStore:
    """Store of items."""

    def __init__(self, table: Table) -> None:
        self._table = table


class DocumentStore(ItemStore):
    """Store of documents: objects, and the items that find them."""

    def __init__(self, table: Table, objects: Objects) -> None:
        super().__init__(table)
        self._objects = objects


def encoded(document: BaseModel) -> bytes:
    """Document as the content of its object."""
    return document.model_dump_json().encode()


def read(objects: Objects, name: str, model: type[Document]) -> Document | None:
    """Read one document."""
    content = objects.get(name)
    return None if content is None else model.model_validate_json(content)


def read_together(objects: Objects, names: Sequence[str]) -> list[bytes | None]:
    """Read objects at the same time; return their contents in order."""
    with ThreadPoolExecutor(READERS) as readers:
        return list(readers.map(objects.get, names))


def read_all(objects: Objects, prefix: str, model: type[Document]) -> Iterator[Document]:
    """Yield the documents below a prefix. For operators, and to rebuild the index."""
    for name in objects.names(prefix):
        document = read(objects, name, model)
        if document is not None:
            yield document


class Jobs(Protocol):
    """Computations outside the request: queued, or awaited."""

    def later(self, job: JobName, payload: bytes) -> None:
        """Queue the job; returns once it is stored. It runs at least once."""
        ...

    def now(self, job: JobName, payload: bytes) -> bytes | None:
        """Run the job and return its result, None if it failed."""
        ...


@dataclass(frozen=True)
class Storage:
    """The ports of one deployment. `site`: public objects, None if this function may not write them."""

    table: Table
    objects: Objects
    jobs: Jobs
    site: Objects | None = None
