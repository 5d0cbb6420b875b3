"""Cameras as the index knows them: what a lookup reads in one Query, and the search."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pydantic_core import from_json

from calibdb.camera_key import PATTERN
from calibdb.schema import ConsensusDocument
from calibdb.schema.cameras import CameraMember
from calibdb.store.consensus import documents
from calibdb.store.keys import StreamMode, calibrations_prefix, camera_pk
from calibdb.store.names import ALL, SAME_AS
from calibdb.store.ports import IF_EXISTS, Item, Table

MIN_RIVAL_SHARE = 1 / 3  # contributors of an id / of the best known one of its name, from which it rivals it


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
    """The cameras of the database."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def known(self, camera_key: str, *, consistent: bool = False) -> CameraRecords:
        """Return all that is known under a key: one Query."""
        items = self._table.query(camera_pk(camera_key), "CONSENSUS", consistent=consistent)
        others = {
            sk.removeprefix(SAME_AS): _id_support(item)
            for item in items
            if (sk := str(item["sk"])).startswith(SAME_AS)
        }
        return CameraRecords(
            documents(item for item in items if "document" in item),
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
        counted = [item for item in items if "withdrawn" not in item and item.get("native", 1) != 0]
        names = {
            str(item["sk"]).rpartition("#")[2]: (str(item["source"]), str(item["mode_name"]))
            for item in counted
            if "mode_name" in item
        }
        return [member for item in counted if (member := _member(item, group)) is not None], names


def _id_support(item: Item) -> IdSupport | None:
    if "well_known" not in item:
        return None
    return IdSupport(bool(item.get("reliable", 0)), int(str(item["well_known"])))


def is_place(word: str, after: str) -> bool:
    """True if a search for `word` can continue at `after`."""
    before, _, key = after.rpartition("#")
    return PATTERN.fullmatch(key) is not None and after.startswith(word) and bool(before) == bool(word)


def _member(item: Item, group: frozenset[str]) -> CameraMember | None:
    fit = from_json(str(item.get("fit", "{}")))
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
