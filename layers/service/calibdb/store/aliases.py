"""Aliases: the labels and platforms under which lookups have found a camera, `ALIAS#<digest>/META`.

`GET /known/v1/<digest>/…` has only the digest, so that no label stands in an address. The item leads from it
to the label, as a lookup sends it. Anyone can invent labels, so their number is bounded per camera, and per
source and day: `ALIASES#<camera key>/TOTAL`, `ALIASES#<source>/DAY#<day>`.
"""

from __future__ import annotations

import hashlib
import time
import unicodedata
from dataclasses import dataclass

from calibdb.store.ports import IF_NOT_EXISTS, Item, Table

MAX_OF_CAMERA = 200
MAX_OF_SOURCE = 20  # per day
_DAY_S = 86_400
ALIAS_EXPIRY_S = 180 * _DAY_S  # after the last lookup, or 30 days less
ALIAS_RENEWAL_S = 30 * _DAY_S  # after which a lookup writes the alias again
_SK = "META"


def alias_digest(label: str, platform: str) -> str:
    """Compute the name of an alias, 32 hex digits: half of a SHA-256 (docs/api.md, "Known cameras")."""
    text = f"v1\n{unicodedata.normalize('NFC', label).strip()}\n{platform}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Alias:
    """A label and platform; `expires`: unix seconds."""

    label: str
    platform: str
    expires: int = 0

    @property
    def digest(self) -> str:
        """Name of the alias."""
        return alias_digest(self.label, self.platform)

    def is_fresh(self, now: float) -> bool:
        """True if nothing need be written of a lookup under it."""
        return self.expires >= now + ALIAS_EXPIRY_S - ALIAS_RENEWAL_S


class Aliases:
    """Store of aliases."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def get(self, digest: str) -> Alias | None:
        """Return the alias of this name, None if there is none."""
        item = self._table.get(_pk(digest), _SK, consistent=False)
        return (
            None if item is None else Alias(str(item["label"]), str(item["platform"]), int(str(item["ttl"])))
        )

    def record(self, alias: Alias, camera_key: str, source: str, now: int) -> bool:
        """Store an alias for `ALIAS_EXPIRY_S` from now; False, and nothing stored, if there are too many."""
        item: Item = {
            "pk": _pk(alias.digest),
            "sk": _SK,
            "camera": camera_key,
            "label": alias.label,
            "platform": alias.platform,
            "ttl": now + ALIAS_EXPIRY_S,
        }
        if self.get(alias.digest) is None:
            day = time.strftime("%Y-%m-%d", time.gmtime(now))
            per_source = self._table.add(
                _counter(source),
                f"DAY#{day}",
                "aliases",
                1,
                limit=MAX_OF_SOURCE,
                ttl=now + 2 * _DAY_S,
            )
            if per_source is None:
                return False
            per_camera = self._table.add(
                _counter(camera_key),
                "TOTAL",
                "aliases",
                1,
                limit=MAX_OF_CAMERA,
                ttl=now + ALIAS_EXPIRY_S,
            )
            if per_camera is None:
                return False
            self._table.put(item, IF_NOT_EXISTS)
            return True
        self._table.put(item)
        return True


def _pk(digest: str) -> str:
    return f"ALIAS#{digest}"


def _counter(owner: str) -> str:
    return f"ALIASES#{owner}"
