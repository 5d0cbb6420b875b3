"""Locks: one writer at a time of what lies at the edge for one camera.

Objects in S3 can be fenced by what they hold, but not by their absence: a writer that is late could create
anew what another has removed. So writers take turns. A lock is a lease: a writer that crashed holds it until
it expires, and one that is slow renews it before each batch of writes.
"""

from __future__ import annotations

from calibdb.store.ports import IF_NOT_EXISTS, Item, Table, below, equals

LEASE_S = 30  # twice what a batch of writes takes at the worst: three attempts of three seconds, twice
_LOCK_SK = "EDGE"
_KEPT_S = 3600  # seconds after which what a crash left behind is removed


class Locks:
    """Locks of cameras, `REFIT#<camera key>/EDGE`."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def take(self, camera_key: str, me: str, now: int) -> bool:
        """Take or renew the lock for `LEASE_S` seconds; False when another holds it.

        `me`: the same for every attempt of one request, so that a second one after a crash goes on.
        """
        free = IF_NOT_EXISTS | equals(holder=me) | below("until", now)
        return self._table.put(_item(camera_key, me, now), free)

    def renew(self, camera_key: str, me: str, now: int) -> bool:
        """Hold the lock for `LEASE_S` seconds from now; False when it was lost."""
        return self._table.put(_item(camera_key, me, now), equals(holder=me))

    def is_held(self, camera_key: str, now: int) -> bool:
        """Tell whether somebody holds the lock."""
        item = self._table.get(_pk(camera_key), _LOCK_SK)
        return item is not None and int(str(item["until"])) >= now

    def release(self, camera_key: str, me: str) -> None:
        """Let go of the lock, if it is still held."""
        self._table.delete(_pk(camera_key), _LOCK_SK, equals(holder=me))


def _pk(camera_key: str) -> str:
    return f"REFIT#{camera_key}"


def _item(camera_key: str, me: str, now: int) -> Item:
    until = now + LEASE_S
    return {"pk": _pk(camera_key), "sk": _LOCK_SK, "holder": me, "until": until, "ttl": until + _KEPT_S}
