"""Cameras in the index: what a lookup reads in one Query, their consensuses, and the search."""

from __future__ import annotations

import functools
import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pydantic import ValidationError
from pydantic_core import from_json

from calibdb.camera_key import PATTERN
from calibdb.schema import ConsensusDocument, GroupsDocument
from calibdb.schema.cameras import CameraMember
from calibdb.store.keys import (
    StreamMode,
    calibrations_prefix,
    camera_pk,
    consensus_sk,
    groups_sk,
    parse_consensus_id,
)
from calibdb.store.names import ALL, SAME_AS
from calibdb.store.ports import IF_EXISTS, IF_NOT_EXISTS, Condition, Item, Table, equals

MIN_RIVAL_SHARE = 1 / 3  # contributors of an id / of the best known one of its name, from which it rivals it

_log = logging.getLogger(__name__)


@dataclass(frozen=True, order=True)
class IdSupport:
    """Support of a USB id among those of its name: its camera's best consensus, and who agrees on it."""

    reliable: bool = False
    contributors: int = 0


def rivals(supports: Mapping[str, IdSupport]) -> tuple[str, ...]:
    """Select the ids that a name may mean.

    If one of them is reliable, only reliable ones, and of those only ones with at least a third of the best
    known one's contributors: an invented id takes no name from a well-known camera.
    """
    if not supports:
        return ()
    best = max(supports.values())
    return tuple(
        key
        for key, support in supports.items()
        if support.reliable >= best.reliable and support.contributors >= MIN_RIVAL_SHARE * best.contributors
    )


@dataclass(frozen=True)
class CameraRecords:
    """Entries under one camera key.

    Attributes
    ----------
    consensuses
        At every size and zoom and for every model.
    same_as
        Keys under which the camera may be known: the USB ids seen with this name, or the key that today's
        rules give to a camera of earlier ones.
    well_known
        Well-known ids among them.
    """

    consensuses: list[ConsensusDocument]
    same_as: tuple[str, ...] = ()
    well_known: tuple[str, ...] = ()

    @property
    def candidates(self) -> tuple[str, ...]:
        """USB ids that the name can mean: one invented id does not rival one that is well known."""
        return self.well_known or self.same_as


class Cameras:
    """The cameras of the database: by their keys, and by the words of their names."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def known(self, camera_key: str) -> CameraRecords:
        """Return all that is known under a key: one Query."""
        items = self._table.query(camera_pk(camera_key), "CONSENSUS")
        others = {
            sk.removeprefix(SAME_AS): _id_support(item)
            for item in items
            if (sk := str(item["sk"])).startswith(SAME_AS)
        }
        return CameraRecords(
            _documents(item for item in items if "document" in item),
            tuple(others),
            rivals({key: support for key, support in others.items() if support}),
        )

    def set_id_support(self, camera_key: str, names: Iterable[str], support: IdSupport | None) -> bool:
        """Store under the keys `names` how well known the camera is; None: not at all.

        False if it was written there already.
        """
        written = False
        for name in sorted(names):
            item: Item = {"pk": camera_pk(name), "sk": SAME_AS + camera_key}
            stored = self._table.get(str(item["pk"]), str(item["sk"]))
            if stored is not None and _id_support(stored) != support:
                mark: Item = {}
                if support is not None:
                    mark = {"well_known": support.contributors, "reliable": int(support.reliable)}
                self._table.put(item | mark, IF_EXISTS)
                written = True
        return written

    def name(self, camera_key: str) -> str | None:
        """Return the normalised label of a camera, None if none is known under this key."""
        item = self._table.get(ALL, camera_key, consistent=False)
        return str(item["name"]) if item else None

    def search(self, word: str, limit: int, after: str | None) -> tuple[list[tuple[str, str]], str | None]:
        """Return cameras of whose names a word begins with `word`, and where to continue: one Query.

        Each by key and normalised label. An empty word finds all. `after`: what an earlier answer for the
        same word gave (`is_place`), or None.
        """
        # A prefix may not be empty; that of every key is its version's letter.
        items, more = self._table.page(ALL + word[:1], word or "c", limit, after)
        names = {str(item["sk"]).rpartition("#")[2]: str(item["name"]) for item in items}
        return list(names.items()), str(items[-1]["sk"]) if more and items else None

    def members(
        self, mode: StreamMode, group: frozenset[str], limit: int
    ) -> tuple[list[CameraMember], dict[str, tuple[str, str]]]:
        """Return the newest calibrations at a size and zoom that count; `group`: those that agree.

        Also, by id, the contributors and names of those whose contributors named the mode.
        """
        prefix = calibrations_prefix(mode.img_size, mode.zoom)
        items = self._table.query(mode.pk, prefix, newest_first=True, limit=limit)
        counted = [item for item in items if "withdrawn" not in item and item["native"] != 0]
        names = {
            str(item["sk"]).rpartition("#")[2]: (str(item["source"]), str(item["mode_name"]))
            for item in counted
            if "mode_name" in item
        }
        return [member for item in counted if (member := _member(item, group)) is not None], names


class Consensuses:
    """The consensuses of cameras: index items that contain what lookups return.

    A computation reads the stored consensus first and its inputs after it. It writes on condition that the
    stored one is still the same. So an older result never replaces a newer one, however long either took.
    """

    def __init__(self, table: Table) -> None:
        self._table = table

    def of(self, camera_key: str) -> list[ConsensusDocument]:
        """Return all of a camera, at every size and zoom and for every model: one Query."""
        return _documents(self._table.query(camera_pk(camera_key), "CONSENSUS#"))

    def at(self, mode: StreamMode) -> list[ConsensusDocument]:
        """Return those of every model at one size and zoom, as they are at this moment."""
        return _documents(self._table.query(mode.pk, f"CONSENSUS#{mode.text}#", consistent=True))

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


def _id_support(item: Item) -> IdSupport | None:
    if "well_known" not in item:
        return None
    return IdSupport(bool(item.get("reliable", 0)), int(str(item["well_known"])))


def is_place(word: str, after: str) -> bool:
    """True if a search for `word` can continue at `after`."""
    before, _, key = after.rpartition("#")
    return PATTERN.fullmatch(key) is not None and after.startswith(word) and bool(before) == bool(word)


def _member(item: Item, group: frozenset[str]) -> CameraMember | None:
    fit = from_json(str(item["fit"]))
    if not fit:
        return None
    (fx, _, cx), (_, fy, cy), _ = fit["camera_matrix"]
    own_id = str(item["sk"]).rpartition("#")[2]
    return CameraMember(
        id=own_id,
        time=int(str(item["time"])),
        fx=fx,
        fy=fy,
        cx=cx,
        cy=cy,
        rms=fit["avg_reprojection_error"],
        model=str(item["model"]),
        in_group=own_id in group,
    )


def _still(before: str | None) -> Condition:
    if before is None:
        return IF_NOT_EXISTS
    return equals(basis=before)


def _documents(items: Iterable[Item]) -> list[ConsensusDocument]:
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
