"""Cameras as the index knows them: what a lookup reads in one Query, and the search."""

from __future__ import annotations

from dataclasses import dataclass

from calibdb.schema import ConsensusDocument
from calibdb.store.consensus import documents
from calibdb.store.keys import camera_pk
from calibdb.store.names import ALL, SAME_AS
from calibdb.store.table import Table


@dataclass(frozen=True)
class Known:
    """What stands under one key.

    Attributes
    ----------
    consensuses
        At every size and zoom and for every model.
    same_as
        Keys under which the camera may be known: the USB ids seen with this name, or the key that today's
        rules give to a camera of earlier ones.

    """

    consensuses: list[ConsensusDocument]
    same_as: tuple[str, ...] = ()


class Cameras:
    """The cameras of the database."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def known(self, camera_key: str) -> Known:
        """Return all that is known under a key: one Query."""
        items = self._table.query(camera_pk(camera_key), "CONSENSUS")
        others = (str(item["sk"]) for item in items)
        return Known(
            documents(item for item in items if "document" in item),
            tuple(sk.removeprefix(SAME_AS) for sk in others if sk.startswith(SAME_AS)),
        )

    def search(self, word: str, limit: int, after: str | None) -> tuple[list[str], str | None]:
        """Return keys of cameras of whose names a word begins with `word`, and where to go on: one Query.

        An empty word finds all. `after` is what an earlier answer gave, or None.
        """
        items, more = self._table.page(ALL + word[:1], word, limit, after)
        found = [str(item["sk"]) for item in items]
        return [sk.rpartition("#")[2] for sk in found], found[-1] if more and found else None
