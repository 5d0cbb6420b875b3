"""Consensuses: index items that hold, ready to send, what a lookup answers."""

from __future__ import annotations

from calibdb.schema import ConsensusDocument
from calibdb.store.keys import camera_pk, consensus_sk, parse_consensus_id
from calibdb.store.table import Condition, Item, Table


class Consensuses:
    """What the calibrations of a camera agree on."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def of(self, camera_key: str) -> list[ConsensusDocument]:
        """Return all of a camera, at every size and zoom and for every model: one Query."""
        return [_document(item) for item in self._table.query(camera_pk(camera_key), "CONSENSUS#")]

    def get(self, consensus_id: str) -> ConsensusDocument | None:
        """Return the consensus with this id, None when there is none."""
        place = parse_consensus_id(consensus_id)
        item = self._table.get(*place, consistent=False) if place else None
        return _document(item) if item else None

    def put(self, document: ConsensusDocument) -> bool:
        """Store the consensus; False when one that considered more or later calibrations is there."""
        names = {"latest": "latest", "total": "total"}
        return self._table.put(
            {
                "pk": camera_pk(document.camera_key),
                "sk": consensus_sk(document.img_size, document.zoom, document.distortion_model),
                "latest": document.latest,
                "total": document.total,
                "document": document.model_dump_json(),
            },
            Condition(
                "attribute_not_exists(pk) OR #latest < :latest OR (#latest = :latest AND #total <= :total)",
                {"latest": document.latest, "total": document.total},
                names,
            ),
        )


def _document(item: Item) -> ConsensusDocument:
    return ConsensusDocument.model_validate_json(str(item["document"]))
