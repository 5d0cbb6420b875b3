"""Single-flight leases: one computation of a mode's consensus at a time serves all who ask for it.

`REFIT#<camera key>#<w>x<h>#<zoom>`: the holder, when the lease expires, and whether another asked since the
holder began. A lease only saves work: correctness comes from the conditional write of the consensus.
"""

from calibdb.store.keys import StreamMode
from calibdb.store.ports import IF_NOT_EXISTS, Item, ItemStore, compared, equals

_SK = "META"
_MAX_ATTEMPTS = 8  # to learn who holds it, while others let go of it and take it
_EXPIRED_S = 3600  # seconds after which what a crash left behind is removed


class Leases(ItemStore):
    """One computation at a time for each mode."""

    def take(self, mode: StreamMode, me: str, now: int, until: int, name: str = _SK) -> bool:
        """Begin to compute; False if another does, which is then asked to repeat it.

        `me`: the same for every attempt of one request, so that a second one after a crash continues.
        `until`: unix seconds at which the computation has surely ended. `name`: of one of several
        computations of the mode.
        """
        free = IF_NOT_EXISTS | equals(holder=me) | compared("until", "<", now)
        for _ in range(_MAX_ATTEMPTS):
            if self._table.put(_item(mode, me, until, asked=0, name=name), free):
                return True
            item = self._table.get(_pk(mode), name)
            if item is None:
                continue
            holder = item["holder"]
            requested = _item(mode, holder, item["until"], asked=1, name=name)
            if self._table.put(requested, equals(holder=holder)):
                return False
        return True  # so much coming and going that one more does not matter

    def release(self, mode: StreamMode, me: str) -> bool:
        """Release it; False, and still held, if another request arrived meanwhile."""
        if self._table.delete(_pk(mode), _SK, equals(holder=me, asked=0)):
            return True
        item = self._table.get(_pk(mode), _SK)
        return item is None or item["holder"] != me

    def abandon(self, mode: StreamMode, me: str, name: str = _SK) -> None:
        """Release it although another request arrived."""
        self._table.delete(_pk(mode), name, equals(holder=me))


def _pk(mode: StreamMode) -> str:
    return f"REFIT#{mode.camera_key}#{mode.text}"


def _item(mode: StreamMode, holder: str, until: int, asked: int, name: str = _SK) -> Item:
    return {
        "pk": _pk(mode),
        "sk": name,
        "holder": holder,
        "until": until,
        "asked": asked,
        "ttl": until + _EXPIRED_S,
    }
