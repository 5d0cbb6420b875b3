"""Quota counters of tokens: `TOKEN#<id>/QUOTA#<hour>`, and the same with `#<contributor>`.

Counters only ever grow, each for one hour; they expire by themselves and are not in the bucket.
"""

from __future__ import annotations

import time

from calibdb.access.plans import HOUR_S, Kind
from calibdb.store.table import Table

_EXPIRY_S = 2 * HOUR_S  # after the hour's end; DynamoDB removes what expired within a day or two


class Quotas:
    """The counters of the current hour."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def take(self, token_id: str, kind: Kind, now: int, limit: int, contributor: str = "") -> bool:
        """Count one more; False, and nothing counted, where `limit` is reached.

        `contributor`: whose share it is; empty: the token's.
        """
        return self._add(token_id, kind, now, 1, limit, contributor) is not None

    def add(self, token_id: str, kind: Kind, now: int, amount: int) -> int:
        """Count what has happened already; return how many it are by now."""
        return self._add(token_id, kind, now, amount, None, "") or 0

    def _add(
        self, token_id: str, kind: Kind, now: int, amount: int, limit: int | None, contributor: str
    ) -> int | None:
        hour = time.strftime("%Y-%m-%dT%H", time.gmtime(now))
        return self._table.add(
            f"TOKEN#{token_id}",
            f"QUOTA#{hour}#{contributor}" if contributor else f"QUOTA#{hour}",
            kind,
            amount,
            limit=limit,
            ttl=now - now % HOUR_S + HOUR_S + _EXPIRY_S,
        )
