"""Join codes of rigs, and how many wrong ones a source has sent.

`RIGCODE#<keyed hash of the code>` names the rig until the code expires. `GUESS#<source>/WINDOW#<number>`
counts guesses: each before it is checked, so that many at once cannot exceed the limit.
"""

from __future__ import annotations

from calibdb.store.ports import ItemStore

GUESS_WINDOW_S = 900
MAX_GUESSES = 10
"""Wrong codes of one source in a window."""
_SK = "META"
_COUNTER = "guesses"


class RigCodes(ItemStore):
    """Join codes by their keyed hashes."""

    def put(self, digest: str, rig_id: str, until: int) -> None:
        """Let a code lead to a rig until a unix time."""
        self._table.put(
            {"pk": _pk(digest), "sk": _SK, "rig": rig_id, "until": until, "ttl": until + GUESS_WINDOW_S}
        )

    def find(self, digest: str, now: int) -> str | None:
        """Rig of a code, None if there is none or the code has expired."""
        item = self._table.get(_pk(digest), _SK)
        return str(item["rig"]) if item and item["until"] > now else None

    def remove(self, digest: str) -> None:
        """Let a code lead nowhere."""
        self._table.delete(_pk(digest), _SK)

    def count_guess(self, source: str, now: int) -> bool:
        """Count a code that may be a guess; False, and nothing counted, if there were too many."""
        number = now // GUESS_WINDOW_S
        ttl = (number + 2) * GUESS_WINDOW_S
        counted = self._table.add(*_guesses(source, number), _COUNTER, 1, limit=MAX_GUESSES, ttl=ttl)
        return counted is not None

    def uncount_guess(self, source: str, now: int) -> None:
        """Take back a guess that was right."""
        self._table.add(*_guesses(source, now // GUESS_WINDOW_S), _COUNTER, -1)


def _pk(digest: str) -> str:
    return f"RIGCODE#{digest}"


def _guesses(source: str, number: int) -> tuple[str, str]:
    return f"GUESS#{source}", f"WINDOW#{number}"
