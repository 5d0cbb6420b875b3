"""Counters of use: `TOKEN#<id>/QUOTA#<hour>`, and `SHARE#<hour>#<contributor>` of one of its users.

Counters only ever grow, each for one hour or day; they expire by themselves and are not in the bucket. Those
of a token are its statistics of use, too.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping

from calibdb.access.plans import HOUR_S, Counter
from calibdb.store.table import Item, Table

_SHARE_EXPIRY_S = 2 * HOUR_S  # after the hour's end; DynamoDB removes what expired within a day or two
_DAY_S = 24 * HOUR_S
USE_DAYS = 30
_USE_EXPIRY_S = (USE_DAYS + 1) * _DAY_S
_EVERYBODY = "all"


class Quotas:
    """The counters of the current hour, and of the hours of the last days."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def take(self, token_id: str, kind: Counter, now: int, limit: int, contributor: str = "") -> int | None:
        """Count one more and return how many it are; None, and nothing counted, where `limit` is reached.

        `contributor`: whose share it is; empty: the token's.
        """
        return self._add(token_id, kind, now, 1, limit, contributor)

    def add(self, token_id: str, kind: Counter, now: int, amount: int) -> int:
        """Count what has happened already; return how many it are by now."""
        return self._add(token_id, kind, now, amount, None, "") or 0

    def use(self, token_id: str, now: int) -> Mapping[str, Mapping[str, int]]:
        """Return the counts of a token by hour (`2026-11-22T16`, UTC) for the last 30 days."""
        found = self._table.query(f"TOKEN#{token_id}", "QUOTA#")
        oldest = hour_text(now - USE_DAYS * _DAY_S)
        return {hour: counts for hour, counts in map(_counts, found) if hour >= oldest}

    def used(self, token_id: str, now: int, contributor: str = "") -> Mapping[str, int]:
        """Return the counts of this hour, the token's or a contributor's."""
        item = self._table.get(f"TOKEN#{token_id}", _sk(now, contributor), consistent=False)
        return _counts(item)[1] if item else {}

    def take_token(self, source: str, now: int, limit: int) -> bool:
        """Count a new token of a source; False, and nothing counted, where the day's are used up."""
        day = time.strftime("%Y-%m-%d", time.gmtime(now))
        ttl = now - now % _DAY_S + 2 * _DAY_S
        if self._table.add(f"ISSUED#{source}", f"DAY#{day}", "tokens", 1, limit=limit, ttl=ttl) is None:
            return False
        kept = now + _USE_EXPIRY_S
        self._table.add(f"ISSUED#{_EVERYBODY}", f"DAY#{day}", "tokens", 1, ttl=kept)
        return True

    def issued(self) -> Iterator[tuple[str, int]]:
        """Yield the days and how many tokens people made for themselves. For operators."""
        for item in self._table.query(f"ISSUED#{_EVERYBODY}", "DAY#"):
            yield str(item["sk"]).removeprefix("DAY#"), int(str(item["tokens"]))

    def _add(
        self, token_id: str, kind: Counter, now: int, amount: int, limit: int | None, contributor: str
    ) -> int | None:
        kept = _SHARE_EXPIRY_S if contributor else _USE_EXPIRY_S
        return self._table.add(
            f"TOKEN#{token_id}",
            _sk(now, contributor),
            kind,
            amount,
            limit=limit,
            ttl=now - now % HOUR_S + HOUR_S + kept,
        )


def hour_text(now: int) -> str:
    """Return the hour of a unix time: `2026-11-22T16`, UTC."""
    return time.strftime("%Y-%m-%dT%H", time.gmtime(now))


def _sk(now: int, contributor: str) -> str:
    return f"SHARE#{hour_text(now)}#{contributor}" if contributor else f"QUOTA#{hour_text(now)}"


def _counts(item: Item) -> tuple[str, dict[str, int]]:
    counts = {name: value for name, value in item.items() if isinstance(value, int) and name != "ttl"}
    return str(item["sk"]).partition("#")[2].partition("#")[0], counts
