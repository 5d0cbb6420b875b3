"""Aliases: labels and platforms under which browsers report a camera, and what lies at the edge for each.

* `CAMERA#<key>/ALIAS#<digest>`: one alias of the camera that `camera_key.identify` names, and the objects
  that were written for it. `objects` is written ahead: it never lacks one that exists.
* `CAMERA#<key>/CONSENSUS-ALIASES`: the digests of all of them. Under `CONSENSUS`, so that the one Query of a
  lookup brings it along.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from calibdb.store.keys import alias_digest, camera_pk
from calibdb.store.ports import Item, Table

MAX_ALIASES = 200  # of one camera
ALIAS_PREFIX = "ALIAS#"
LIST_SK = "CONSENSUS-ALIASES"


@dataclass(frozen=True)
class Alias:
    """One label and platform of a camera.

    Attributes
    ----------
    label, platform
        As a lookup sends them.
    seen
        Whether a calibration bears them. Others are known from lookups alone.
    sources
        Of the lookups under an alias that too few have asked by, hashed; nothing is written for it yet.
    time
        Unix seconds of the last lookup that was counted; 0 where it was seen.
    objects
        ETags of the objects by the text of their mode and model, `1280x720#0#rectilinear`; empty while a
        write or a removal is under way.
    """

    label: str
    platform: str
    seen: bool = False
    sources: tuple[str, ...] = ()
    time: int = 0
    objects: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> tuple[str, str]:
        """Label and platform."""
        return self.label, self.platform

    @property
    def digest(self) -> str:
        """Name of the item."""
        return alias_digest(self.label, self.platform)

    @property
    def confirmed(self) -> bool:
        """Tell whether objects may be written for it."""
        return self.seen or not self.sources


@dataclass(frozen=True)
class AliasList:
    """Digests of a camera's aliases: the confirmed ones, and those that more must ask by."""

    confirmed: frozenset[str]
    pending: frozenset[str]

    def wants(self, digest: str) -> bool:
        """Tell whether a lookup under this alias is worth writing down."""
        if digest in self.confirmed:
            return False
        return digest in self.pending or len(self.confirmed) + len(self.pending) < MAX_ALIASES


NO_ALIASES = AliasList(frozenset(), frozenset())


class Aliases:
    """Store of aliases, each under the key that label and platform give."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def of(self, camera_key: str) -> list[Alias]:
        """Return all of a camera, as they are at this moment."""
        items = self._table.query(camera_pk(camera_key), ALIAS_PREFIX, consistent=True)
        return [_alias(item) for item in items]

    def put(self, camera_key: str, alias: Alias) -> None:
        """Write the alias."""
        self._table.put(_item(camera_key, alias))

    def remove(self, camera_key: str, alias: Alias) -> None:
        """Forget the alias."""
        self._table.delete(camera_pk(camera_key), ALIAS_PREFIX + alias.digest)

    def put_list(self, camera_key: str, aliases: Sequence[Alias]) -> None:
        """Tell lookups which aliases there are, where they have not been told the same before."""
        pk = camera_pk(camera_key)
        stored = self._table.get(pk, LIST_SK)
        if not aliases:
            if stored is not None:
                self._table.delete(pk, LIST_SK)
            return
        confirmed = sorted(alias.digest for alias in aliases if alias.confirmed)
        pending = sorted(alias.digest for alias in aliases if not alias.confirmed)
        item: Item = {"pk": pk, "sk": LIST_SK, "confirmed": confirmed, "pending": pending}
        if item != stored:
            self._table.put(item)


def parse_list(item: Item) -> AliasList:
    """Parse the item that a lookup's Query brings along."""
    return AliasList(*(frozenset(_texts(item, name)) for name in ("confirmed", "pending")))


def _texts(item: Item, name: str) -> list[str]:
    found = item.get(name)
    return found if isinstance(found, list) else []


def _alias(item: Item) -> Alias:
    pairs = (text.rpartition("=") for text in _texts(item, "objects"))
    return Alias(
        label=str(item["label"]),
        platform=str(item["platform"]),
        seen="seen" in item,
        sources=tuple(_texts(item, "sources")),
        time=int(str(item.get("time", 0))),
        objects={mode: etag for mode, _, etag in pairs},
    )


def _item(camera_key: str, alias: Alias) -> Item:
    item: Item = {
        "pk": camera_pk(camera_key),
        "sk": ALIAS_PREFIX + alias.digest,
        "label": alias.label,
        "platform": alias.platform,
        "objects": [f"{mode}={etag}" for mode, etag in sorted(alias.objects.items())],
    }
    if alias.seen:
        item["seen"] = 1
    if alias.sources:
        item["sources"] = list(alias.sources)
    if alias.time:
        item["time"] = alias.time
    return item
