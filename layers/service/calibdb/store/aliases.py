"""Aliases: the labels and platforms under which lookups have found a camera, `ALIAS#<digest>/META`.

`GET /known/v1/<digest>/…` has only the digest, so that no label stands in an address. The item leads from it
to the label, as a lookup sends it. Anyone can invent labels, so their number is bounded per camera, and per
source and day: `ALIASES#<camera key>/TOTAL`, `ALIASES#<source>/DAY#<day>`.
"""

import hashlib
import time
import unicodedata
from dataclasses import dataclass

from calibdb.store.ports import IF_NOT_EXISTS, Item, ItemStore

MAX_OF_CAMERA = 200
MAX_OF_SOURCE = 20  # per day
_DAY_S = 86_400
ALIAS_EXPIRY_S = 180 * _DAY_S  # after the last lookup, or 30 days less
ALIAS_RENEWAL_S = 30 * _DAY_S  # after which a lookup writes the alias again
_SK = "META"


def alias_digest(label: str, platform: str) -> str:
    """Compute the name of an alias (docs/api.md, "Known cameras")."""
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


class Aliases(ItemStore):
    """Store of aliases."""

    def get(self, digest: str) -> Alias | None:
        """Alias of this name."""
        item = self._table.get(_pk(digest), _SK, consistent=False)
        return None if item is None else Alias(item["label"], item["platform"], item["ttl"])

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
        if self.get(alias.digest) is not None:
            self._table.put(item)
            return True
        day = time.strftime("%Y-%m-%d", time.gmtime(now))
        if not self._count(source, f"DAY#{day}", MAX_OF_SOURCE, now + 2 * _DAY_S):
            return False
        if not self._count(camera_key, "TOTAL", MAX_OF_CAMERA, now + ALIAS_EXPIRY_S):
            return False
        self._table.put(item, IF_NOT_EXISTS)
        return True

    def _count(self, owner: str, sk: str, limit: int, ttl: int) -> bool:
        return self._table.add(f"ALIASES#{owner}", sk, "aliases", 1, limit=limit, ttl=ttl) is not None


def _pk(digest: str) -> str:
    return f"ALIAS#{digest}"
