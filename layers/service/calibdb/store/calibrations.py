"""Finished calibrations: objects that hardly change, and the index items that find them.

Only a licence is ever added to an object, and an operator may remove the name of its mode.

One that was withdrawn keeps its object, next to a tombstone `<id>.withdrawn.json`, and its item is marked. It
counts for nothing any more, and publishing it again does not bring it back.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from pydantic import ValidationError

from calibdb.errors import DeniedReadError
from calibdb.rules.quality_gates import is_evidence
from calibdb.rules.votes import view_digest
from calibdb.schema import CalibrationDocument
from calibdb.schema.fields import CROPPED
from calibdb.schema.licence import Licensed
from calibdb.store.keys import (
    WITHDRAWN,
    StreamMode,
    calibration_object,
    camera_pk,
    with_tombstones,
)
from calibdb.store.names import Names, with_current_key
from calibdb.store.ports import DocumentStore, Item, Objects, Table, compared, encoded, read_together

MAX_PER_SOURCE = 3  # calibrations of one source that enter a consensus
Withdrawal = Literal["wrong", "abuse", "privacy", "other"]
WITHDRAWALS: tuple[Withdrawal, ...] = get_args(Withdrawal)
_MAX_CALIBRATIONS = 2_000  # of a mode that are looked through for those that count
_NOT_WITHDRAWN = compared("withdrawn", "absent")


@dataclass(frozen=True)
class CountedCalibration:
    """A calibration that counts, as the index knows it."""

    id: str
    source: str  # as what its contributor is counted
    views: frozenset[str]  # their digests (`rules.votes.view_digest`)


class Calibrations(DocumentStore):
    """Calibrations under their ids."""

    def __init__(self, table: Table, objects: Objects) -> None:
        super().__init__(table, objects)
        self._catalogue = Names(table)

    def get(self, calibration_id: str) -> CalibrationDocument | None:
        """Calibration, None if there is none that this version can read."""
        name = calibration_object(calibration_id)
        content = self._objects.get(name) if name else None
        return _document(content) if content is not None else None

    def withdrawal(self, document: CalibrationDocument) -> Withdrawal | None:
        """Return for what kind of reason the calibration was withdrawn, None if it counts.

        What an operator wrote beyond the kind is for operators.
        """
        content = self._objects.get(_tombstone(document.id))
        if content is None:
            return None
        said = str(json.loads(content).get("reason", "")).casefold()
        return next((kind for kind in WITHDRAWALS if said.startswith(kind)), "other")

    def publish(self, document: CalibrationDocument) -> None:
        """Store the calibration and let the index find it; idempotent."""
        if not self._objects.create(_name(document.id), encoded(document)):
            document = self.get(document.id) or document  # with what was changed since
        if self._table.put(_item(document), _NOT_WITHDRAWN):
            self._catalogue.publish(document)

    def license(self, calibration_id: str, given: Licensed) -> None:
        """Add a licence to a calibration that has none."""
        self._change(calibration_id, lambda document: {} if document.licence else given.consent)

    def remove_mode_name(self, calibration_id: str) -> bool:
        """Remove the name that a contributor gave to the mode; False if there is none."""
        return self._change(
            calibration_id, lambda document: {"mode_name": None} if document.mode_name else {}
        )

    def _change(
        self, calibration_id: str, change: Callable[[CalibrationDocument], Mapping[str, str | None]]
    ) -> bool:
        """Replace the members that `change` returns, in the object and the item; False if there are none."""
        name = _name(calibration_id)
        while (version := self._objects.get_version(name)) is not None:
            document = CalibrationDocument.model_validate_json(version[0])
            if not (update := change(document)):
                return False
            changed = document.model_copy(update=update)
            if self._objects.replace(name, encoded(changed), version[1]):
                self._table.put(_item(changed), _NOT_WITHDRAWN)
                return True
        return False

    def index(self, document: CalibrationDocument, *, withdrawn: bool = False) -> None:
        """Write the index item, which follows from the bucket."""
        if withdrawn:
            self._table.put({**_item(document), "withdrawn": 1})
        else:
            self._table.put(_item(document), _NOT_WITHDRAWN)
            self._catalogue.index(document)

    def withdraw(self, document: CalibrationDocument, reason: str, now: int) -> bool:
        """Let the calibration count for nothing any more; False if it was withdrawn before."""
        content = json.dumps({"layout": 1, "id": document.id, "reason": reason, "time": now})
        created = self._objects.create(_tombstone(document.id), content.encode())
        self.index(document, withdrawn=True)
        self._catalogue.remove(document, [name for _, name in self._places(document.current_key)])
        return created

    def unindex(self, document: CalibrationDocument) -> None:
        """Remove the index item of a calibration that is to be removed."""
        item = _item(document)
        self._table.delete(item["pk"], item["sk"])

    def newest(self, mode: StreamMode, limit: int, period: int = 0) -> list[CountedCalibration]:
        """Return at most `limit` calibrations of a mode that count, last ended first.

        If there are more, those of the last days. They are not withdrawn, and of the stream as the camera
        gives it. With a `period`, seconds, contributors are distinguished: then only evidence
        (`quality_gates.is_evidence`), one of each source in a period, and of each source the newest
        `MAX_PER_SOURCE`. 0: all.
        """
        counted: list[CountedCalibration] = []
        # Mostly all of them count. If not, many that do not count must not hide one that does.
        for items_limit in (limit + limit // 4, _MAX_CALIBRATIONS):
            # Ids sort by the day on which the session was started.
            items = self._table.query(
                mode.pk, mode.calibrations, newest_first=True, limit=items_limit, consistent=True
            )
            items.sort(key=lambda item: (item["time"], item["sk"]), reverse=True)
            counted = _select_counted(items, period)[:limit]
            if len(counted) == limit or len(items) < items_limit:
                break
        return counted

    def modes(self, camera_key: str) -> list[StreamMode]:
        """Sizes and zooms at which the camera was calibrated."""
        modes = {mode for mode, _ in self._places(camera_key)}
        return sorted(modes, key=lambda mode: (mode.img_size, mode.zoom))

    def names(self, camera_key: str) -> set[tuple[str, str]]:
        """Labels and platforms of the camera's calibrations that were not withdrawn."""
        return {(item["camera"], item["platform"]) for item in self._not_withdrawn(camera_key)}

    def licence(self, camera_key: str) -> str | None:
        """Licence under which every calibration of the camera was given; None of one without."""
        licences = {item.get("licence") for item in self._not_withdrawn(camera_key)}
        return licences.pop() if len(licences) == 1 else None

    def _not_withdrawn(self, camera_key: str, *, consistent: bool = False) -> list[Item]:
        items = self._table.query(camera_pk(camera_key), "CALIBRATION#", consistent=consistent)
        return [item for item in items if "withdrawn" not in item]

    def _places(self, camera_key: str) -> list[tuple[StreamMode, str]]:
        places = []
        for item in self._not_withdrawn(camera_key, consistent=True):
            _, size, zoom, calibration_id = item["sk"].split("#")
            width, height = map(int, size.split("x"))
            places.append((StreamMode(camera_key, (width, height), float(zoom)), calibration_id))
        return places

    def read(self, ids: Sequence[str]) -> list[CalibrationDocument]:
        """Calibrations with these ids in their order, without those of a later version.

        Raises DeniedReadError if one that the index names is not there.
        """
        documents = []
        for content in read_together(self._objects, [_name(name) for name in ids]):
            if content is None:  # an object is written before its item
                raise DeniedReadError("A calibration that the index names could not be read.")
            documents.append(_document(content))
        return [document for document in documents if document is not None]

    def all(self) -> Iterator[CalibrationDocument]:
        """Yield every calibration in the bucket, withdrawn or not."""
        for document, _ in self.everything():
            yield document

    def everything(self) -> Iterator[tuple[CalibrationDocument, bool]]:
        """Yield every calibration in the bucket, and whether it was withdrawn: what the index is made of."""
        for _, name, withdrawn in with_tombstones(self._objects.names("calibrations/")):
            content = self._objects.get(name)
            document = _document(content) if content is not None else None
            if document is not None:
                yield document, withdrawn


def _select_counted(items: Sequence[Item], period: int) -> list[CountedCalibration]:
    counted, periods = [], set()
    entered: Counter[str] = Counter()
    for item in items:
        if "withdrawn" in item or item["native"] == 0:
            continue
        source = item["source"]
        if period:
            place = source, item["time"] // period
            if item["precise"] == 0 or place in periods or entered[source] == MAX_PER_SOURCE:
                continue
            periods.add(place)
            entered[source] += 1
        calibration_id = item["sk"].rpartition("#")[2]
        counted.append(CountedCalibration(calibration_id, source, frozenset(item["views"].split())))
    return counted


def _document(content: bytes) -> CalibrationDocument | None:
    try:
        return with_current_key(CalibrationDocument.model_validate_json(content))
    except ValidationError:  # of a later version, whose models this one does not know
        return None


def _name(calibration_id: str) -> str:
    name = calibration_object(calibration_id)
    if name is None:
        raise ValueError(f"not the id of a calibration: {calibration_id!r}")
    return name


def _tombstone(calibration_id: str) -> str:
    return _name(calibration_id).removesuffix(".json") + WITHDRAWN


def _item(document: CalibrationDocument) -> Item:
    document = with_current_key(document)
    fit = document.fits.get(document.distortion_model)
    shown = fit.model_dump_json(include={"camera_matrix", "avg_reprojection_error"}) if fit else "{}"
    item: Item = {"licence": document.licence} if document.licence else {}
    if document.mode_name:
        item["mode_name"] = document.mode_name
    mode = StreamMode(document.camera_key, document.img_size, document.zoom)
    return item | {
        "pk": mode.pk,
        "sk": mode.calibrations + document.id,
        "camera": document.camera,
        "contributor": document.contributor,
        "fit": shown,
        "model": document.distortion_model,
        "native": int(document.track.resizeMode != CROPPED),
        "platform": document.platform,
        "precise": int(is_evidence(document)),
        "source": document.counted_as,
        "time": document.time,
        "views": " ".join(view_digest(view.ids, view.points) for view in document.views),
    }
