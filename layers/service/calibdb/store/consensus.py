"""Consensuses: index items that hold the answers to lookups, ready to send.

A computation reads first the stored consensus, then its inputs, and writes on condition that the stored one
is still the same. So an older result never replaces a newer one, however long either took.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Iterable

from pydantic import ValidationError

from calibdb.schema import ConsensusDocument, GroupsDocument
from calibdb.store.keys import StreamMode, camera_pk, consensus_sk, groups_sk, parse_consensus_id
from calibdb.store.ports import IF_NOT_EXISTS, Condition, Item, Table, absent, equals

_log = logging.getLogger(__name__)


class Consensuses:
    """Store of consensuses."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def of(self, camera_key: str) -> list[ConsensusDocument]:
        """Return all of a camera, at every size and zoom and for every model: one Query."""
        return documents(self._table.query(camera_pk(camera_key), "CONSENSUS#"))

    def at(self, mode: StreamMode) -> list[ConsensusDocument]:
        """Return those of every model at one size and zoom, as they are at this moment."""
        return documents(self._table.query(mode.pk, f"CONSENSUS#{mode.text}#", consistent=True))

    def get(self, consensus_id: str) -> ConsensusDocument | None:
        """Return the consensus with this id, None if there is none."""
        place = parse_consensus_id(consensus_id)
        item = self._table.get(*place, consistent=False) if place else None
        return _document(item) if item else None

    def put(self, document: ConsensusDocument, groups: GroupsDocument | None, before: str | None) -> bool:
        """Store the consensus, and what is behind it; False if another was stored meanwhile.

        `groups`: None if they are as they were. `before`: `basis` of the one that was stored when the
        calibrations were read; None: there was none.
        """
        place = document.img_size, document.zoom, document.distortion_model
        pk = camera_pk(document.camera_key)
        consensus: Item = {
            "pk": pk,
            "sk": consensus_sk(*place),
            "basis": document.basis,
            "document": document.model_dump_json(),
        }
        if groups is None:
            return self._table.put(consensus, _still(before))
        behind: Item = {"pk": pk, "sk": groups_sk(*place), "document": groups.model_dump_json()}
        return self._table.put_transaction((consensus, behind), _still(before))

    def drop(self, document: ConsensusDocument) -> bool:
        """Forget the consensus: all that it rested on is gone. False if another was stored meanwhile."""
        place = document.img_size, document.zoom, document.distortion_model
        pk = camera_pk(document.camera_key)
        if not self._table.delete(pk, consensus_sk(*place), _still(document.basis)):
            return False
        self._table.delete(pk, groups_sk(*place))
        return True

    def groups(self, document: ConsensusDocument) -> GroupsDocument | None:
        """Read the groups document behind the consensus, None if it has changed meanwhile."""
        sk = groups_sk(document.img_size, document.zoom, document.distortion_model)
        item = self._table.get(camera_pk(document.camera_key), sk, consistent=False)
        if item is None:
            return None
        groups_document = GroupsDocument.model_validate_json(str(item["document"]))
        return groups_document if groups_document.pooled == document.pooled else None


def _still(before: str | None) -> Condition:
    if before is None:
        return IF_NOT_EXISTS
    # Items without a basis, from earlier versions, give way.
    return absent("basis") | equals(basis=before)


def documents(items: Iterable[Item]) -> list[ConsensusDocument]:
    """Parse the items, without those that this version cannot read."""
    return [document for item in items if (document := _document(item)) is not None]


def _document(item: Item) -> ConsensusDocument | None:
    try:
        return _parsed(str(item["document"]))
    except ValidationError:
        # Of a later version that is being rolled out: its models are not known here, the others are.
        _log.warning("%s of %s is not of this version", item["sk"], item["pk"])
        return None


@functools.lru_cache(maxsize=64)  # documents are frozen, and lookups read the same ones again and again
def _parsed(text: str) -> ConsensusDocument:
    return ConsensusDocument.model_validate_json(text)
