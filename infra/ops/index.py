"""Keys of the whole table, and the removal of many items, which only operators do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

from calibdb.store.ports import READERS, Table

Key = tuple[str, str]  # pk, sk


class Index:
    """Keys of all items, and the removal of many."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def keys(self, *prefixes: str) -> Iterator[Key]:
        """Yield the keys whose `pk` begins with one of `prefixes`. Reads the whole table for each."""
        for prefix in prefixes:
            yield from self._table.keys(prefix)

    def sort_keys(self, pk: str, prefix: str) -> Iterator[str]:
        """Yield the `sk` of one partition that begin with `prefix`, in order."""
        return (str(item["sk"]) for item in self._table.query(pk, prefix, consistent=True))

    def remove(self, keys: Iterable[Key]) -> int:
        """Remove the items under these keys; return the number of keys."""
        unique = sorted(set(keys))
        with ThreadPoolExecutor(READERS) as workers:
            list(workers.map(lambda key: self._table.delete(*key), unique))
        return len(unique)
