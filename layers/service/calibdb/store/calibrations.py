"""Finished calibrations: objects that are never overwritten, and the index items that find them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

from calibdb.schema import CalibrationDocument
from calibdb.store.keys import calibration_object, calibrations_prefix, camera_pk
from calibdb.store.objects import Objects
from calibdb.store.table import Item, Table

_READERS = 8  # objects read at a time


class Calibrations:
    """Calibrations under their ids."""

    def __init__(self, table: Table, objects: Objects) -> None:
        self._table = table
        self._objects = objects

    def get(self, calibration_id: str) -> CalibrationDocument | None:
        """Return the calibration, None when there is none."""
        name = calibration_object(calibration_id)
        content = self._objects.get(name) if name else None
        return CalibrationDocument.model_validate_json(content) if content is not None else None

    def publish(self, document: CalibrationDocument) -> None:
        """Store the calibration and let the index find it; done twice, it is done once."""
        self._objects.create(_name(document.id), document.model_dump_json().encode())
        self.index(document)

    def index(self, document: CalibrationDocument) -> None:
        """Write the index item; it follows from the document, so that writing it again changes nothing."""
        self._table.put(_item(document))

    def newest(self, camera_key: str, img_size: tuple[int, int], zoom: float, limit: int) -> list[str]:
        """Return ids of at most `limit` calibrations of a camera at one size and zoom, last begun first."""
        items = self._table.query(
            camera_pk(camera_key),
            calibrations_prefix(img_size, zoom),
            newest_first=True,  # ids sort by the time at which the session was started
            limit=limit,
            consistent=True,
        )
        return [str(item["sk"]).rpartition("#")[2] for item in items]

    def read(self, ids: Sequence[str]) -> list[CalibrationDocument]:
        """Return the calibrations with these ids, those that there are, in their order."""
        return [document for document in self._read(ids) if document is not None]

    def all(self) -> Iterator[CalibrationDocument]:
        """Yield every calibration in the bucket: what the index is rebuilt from."""
        for name in self._objects.names("calibrations/"):
            content = self._objects.get(name)
            if content is not None:
                yield CalibrationDocument.model_validate_json(content)

    def _read(self, ids: Sequence[str]) -> list[CalibrationDocument | None]:
        if len(ids) < 2:
            return [self.get(calibration_id) for calibration_id in ids]
        with ThreadPoolExecutor(min(_READERS, len(ids))) as readers:
            return list(readers.map(self.get, ids))


def _name(calibration_id: str) -> str:
    name = calibration_object(calibration_id)
    if name is None:
        raise ValueError(f"not the id of a calibration: {calibration_id!r}")
    return name


def _item(document: CalibrationDocument) -> Item:
    return {
        "pk": camera_pk(document.camera_key),
        "sk": calibrations_prefix(document.img_size, document.zoom) + document.id,
        "contributor": document.contributor,
        "model": document.distortion_model,
        "time": document.time,
    }
