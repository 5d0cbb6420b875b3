"""Votes, checks of a consensus on fresh views: immutable objects, and the items that find them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from calibdb.schema import VoteDocument
from calibdb.store.keys import Mode, camera_pk, vote_object
from calibdb.store.objects import Objects
from calibdb.store.table import Item, Table

MOST = 50  # the newest; more could only repeat them
_READERS = 8  # objects read at a time


@dataclass(frozen=True)
class Cast:
    """A vote as the index knows it."""

    id: str
    contributor: str
    time: int  # unix seconds


class Votes:
    """What contributors found of a camera's consensus at one size and zoom."""

    def __init__(self, table: Table, objects: Objects) -> None:
        self._table = table
        self._objects = objects

    def cast(self, document: VoteDocument) -> VoteDocument:
        """Store the vote, and return it as it is stored: the first one cast under its id."""
        name = vote_object(document.camera_key, document.id)
        stored = document
        if not self._objects.create(name, document.model_dump_json().encode()):
            first = self._objects.get(name)
            stored = VoteDocument.model_validate_json(first) if first is not None else document
        self.index(stored)
        return stored

    def index(self, document: VoteDocument) -> None:
        """Write the index item; it follows from the document, so that writing it again changes nothing."""
        self._table.put(_item(document))

    def newest(self, mode: Mode) -> list[Cast]:
        """Return the votes on a mode, newest first."""
        items = self._table.query(
            mode.pk, f"VOTE#{mode.text}#", newest_first=True, limit=MOST, consistent=True
        )
        return [
            Cast(str(item["sk"]).rpartition("#")[2], str(item["contributor"]), int(str(item["time"])))
            for item in items
        ]

    def read(self, camera_key: str, ids: Sequence[str]) -> list[VoteDocument]:
        """Return the votes with these ids, those that there are, in their order."""
        names = [vote_object(camera_key, vote_id) for vote_id in ids]
        if not names:
            return []
        with ThreadPoolExecutor(min(_READERS, len(names))) as readers:
            contents = list(readers.map(self._objects.get, names))
        return [VoteDocument.model_validate_json(content) for content in contents if content is not None]

    def all(self) -> Iterator[VoteDocument]:
        """Yield every vote in the bucket: what the index is rebuilt from."""
        for name in self._objects.names("votes/"):
            content = self._objects.get(name)
            if content is not None:
                yield VoteDocument.model_validate_json(content)


def _item(document: VoteDocument) -> Item:
    mode = Mode(document.camera_key, document.img_size, document.zoom)
    return {
        "pk": camera_pk(document.camera_key),
        "sk": f"VOTE#{mode.text}#{document.id}",
        "contributor": document.contributor,
        "time": document.time,
    }
