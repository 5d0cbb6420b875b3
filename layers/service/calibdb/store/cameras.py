"""Cameras in the index: what a lookup reads in one Query, their consensuses, and the search."""

import functools
import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pydantic import ValidationError
from pydantic_core import from_json

from calibdb.camera_key import PATTERN
from calibdb.schema import ConsensusDocument, GroupsDocument
from calibdb.schema.cameras import CameraMember
from calibdb.store.keys import StreamMode, camera_pk, parse_consensus_id
from calibdb.store.names import ALL, SAME_AS
from calibdb.store.ports import IF_NOT_EXISTS, Item, ItemStore, equals

MIN_RIVAL_SHARE = 1 / 3  # contributors of an id / of the best known one of its name, from which it rivals it

_log = logging.getLogger(__name__)


@dataclass(frozen=True, order=True)
class IdSupport:
    """Support of a USB id among those of its name, by its camera's best consensus."""

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
    """Entries under one camera key."""

    consensuses: list[ConsensusDocument]  # at every size and zoom and for every model
    same_as: tuple[str, ...] = ()  # other keys of the camera: USB ids seen with this name, or today's key
    well_known: tuple[str, ...] = ()  # well-known ids among them

    @property
    def candidates(self) -> tuple[str, ...]:
        """USB ids that the name can mean: one invented id does not rival one that is well known."""
        return self.well_known or self.same_as


class Cameras(ItemStore):
    """The cameras of the database: by their keys, and by the words of their names."""

    def known(self, camera_key: str) -> CameraRecords:
        """Return all that is known under a key: one Query."""
        items = self._table.query(camera_pk(camera_key), "CONSENSUS")
        others = [item for item in items if item["sk"].startswith(SAME_AS)]
        supports = {item["sk"].removeprefix(SAME_AS): _id_support(item) for item in others}
        return CameraRecords(
            _documents(item for item in items if "document" in item),
            tuple(supports),
            rivals({key: support for key, support in supports.items() if support}),
        )

    def set_id_support(self, camera_key: str, names: Iterable[str], support: IdSupport | None) -> bool:
        """Store under the keys `names` how well known the camera is; False if it was stored before."""
        mark: Item = {}
        if support is not None:
            mark = {"well_known": support.contributors, "reliable": int(support.reliable)}
        written = False
        for name in sorted(names):
            pk, sk = camera_pk(name), SAME_AS + camera_key
            stored = self._table.get(pk, sk)
            if stored is not None and _id_support(stored) != support:
                self._table.put({"pk": pk, "sk": sk, **mark}, equals(pk=pk))  # if it still exists
                written = True
        return written

    def name(self, camera_key: str) -> str | None:
        """Normalised label of a camera, None if none is known under this key."""
        item = self._table.get(ALL, camera_key, consistent=False)
        return str(item["name"]) if item else None

    def search(self, word: str, limit: int, after: str | None) -> tuple[list[tuple[str, str]], str | None]:
        """Return key and normalised label of cameras with a word that begins with `word`: one Query.

        Also the next `after`, which `is_place` checks. An empty word finds all.
        """
        # A prefix may not be empty; that of every key is its version's letter.
        items = self._table.query(ALL + word[:1], word or "c", limit=limit + 1, after=after)
        names = {_own_id(item): item["name"] for item in items[:limit]}
        return list(names.items()), items[limit - 1]["sk"] if len(items) > limit else None

    def members(
        self, mode: StreamMode, group: frozenset[str], limit: int
    ) -> tuple[list[CameraMember], dict[str, tuple[str, str]]]:
        """Newest calibrations at a size and zoom that count; `group`: those that agree.

        Also, by id, the contributors and names of those whose contributors named the mode.
        """
        items = self._table.query(mode.pk, mode.calibrations, newest_first=True, limit=limit)
        counted = [item for item in items if "withdrawn" not in item and item["native"] != 0]
        names = {
            _own_id(item): (item["source"], item["mode_name"]) for item in counted if "mode_name" in item
        }
        members = (_member(item, group) for item in counted)
        return [member for member in members if member is not None], names


class Consensuses(ItemStore):
    """The consensuses of cameras: index items that contain what lookups return.

    A computation reads the stored consensus first and its inputs after it. It writes on condition that the
    stored one is still the same. So an older result never replaces a newer one, however long either took.
    """

    def of(self, camera_key: str) -> list[ConsensusDocument]:
        """Return all of a camera, at every size and zoom and for every model: one Query."""
        return _documents(self._table.query(camera_pk(camera_key), "CONSENSUS#"))

    def at(self, mode: StreamMode) -> list[ConsensusDocument]:
        """Return those of every model at one size and zoom, read consistently."""
        return _documents(self._table.query(mode.pk, f"CONSENSUS#{mode.text}#", consistent=True))

    def get(self, consensus_id: str) -> ConsensusDocument | None:
        """Consensus with this id."""
        place = parse_consensus_id(consensus_id)
        item = self._table.get(*place, consistent=False) if place else None
        return _document(item) if item else None

    def put(self, document: ConsensusDocument, groups: GroupsDocument | None, before: str | None) -> bool:
        """Store the consensus, and the groups unless they are None; False if another was stored meanwhile.

        `before`: `basis` of the one that was stored when the calibrations were read; None: there was none.
        """
        pk, consensus_sk, groups_sk = _keys(document)
        consensus: Item = {
            "pk": pk,
            "sk": consensus_sk,
            "basis": document.basis,
            "document": document.model_dump_json(),
        }
        unchanged = IF_NOT_EXISTS if before is None else equals(basis=before)
        if groups is None:
            return self._table.put(consensus, unchanged)
        behind: Item = {"pk": pk, "sk": groups_sk, "document": groups.model_dump_json()}
        return self._table.put_transaction((consensus, behind), unchanged)

    def drop(self, document: ConsensusDocument) -> bool:
        """Forget the consensus; False if another was stored meanwhile."""
        pk, consensus_sk, groups_sk = _keys(document)
        if not self._table.delete(pk, consensus_sk, equals(basis=document.basis)):
            return False
        self._table.delete(pk, groups_sk)
        return True

    def groups(self, document: ConsensusDocument) -> GroupsDocument | None:
        """Read the groups document behind the consensus, None if it has changed meanwhile."""
        pk, _, groups_sk = _keys(document)
        item = self._table.get(pk, groups_sk, consistent=False)
        if item is None:
            return None
        groups_document = GroupsDocument.model_validate_json(item["document"])
        return groups_document if groups_document.pooled == document.pooled else None


def _keys(document: ConsensusDocument) -> tuple[str, str, str]:
    """Partition of a consensus, its `sk`, and that of its groups."""
    mode = StreamMode(document.camera_key, document.img_size, document.zoom)
    place = f"{mode.text}#{document.distortion_model}"
    return mode.pk, f"CONSENSUS#{place}", f"GROUPS#{place}"


def _own_id(item: Item) -> str:
    return str(item["sk"]).rpartition("#")[2]


def _id_support(item: Item) -> IdSupport | None:
    if "well_known" not in item:
        return None
    return IdSupport(bool(item.get("reliable", 0)), item["well_known"])


def is_place(word: str, after: str) -> bool:
    """True if a search for `word` can continue at `after`."""
    before, _, key = after.rpartition("#")
    return PATTERN.fullmatch(key) is not None and after.startswith(word) and bool(before) == bool(word)


def _member(item: Item, group: frozenset[str]) -> CameraMember | None:
    fit = from_json(item["fit"])
    if not fit:
        return None
    (fx, _, cx), (_, fy, cy), _ = fit["camera_matrix"]
    return CameraMember(
        id=_own_id(item),
        time=item["time"],
        fx=fx,
        fy=fy,
        cx=cx,
        cy=cy,
        rms=fit["avg_reprojection_error"],
        model=item["model"],
        in_group=_own_id(item) in group,
    )


def _documents(items: Iterable[Item]) -> list[ConsensusDocument]:
    return [document for item in items if (document := _document(item)) is not None]


def _document(item: Item) -> ConsensusDocument | None:
    try:
        return _parsed(item["document"])
    except ValidationError:  # of a later version, whose models this one does not know
        _log.warning("%s of %s is not of this version", item["sk"], item["pk"])
        return None


@functools.lru_cache(maxsize=64)  # documents are frozen, and lookups read the same ones repeatedly
def _parsed(text: str) -> ConsensusDocument:
    return ConsensusDocument.model_validate_json(text)
