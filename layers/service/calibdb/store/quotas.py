"""Counters of use: `TOKEN#<id>/QUOTA#<hour>`, and `SHARE#<hour>#<contributor>` of one of its users.

DynamoDB writes an item, and a partition key, at most 1,000 times a second. So counters of a token lie under
eight keys: `TOKEN#<id>`, and `TOKEN#<id>#1` to `#7`. A user's share has one of them; what all users have
together is split if the limit is large.
"""

import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from random import randrange
from zlib import crc32

from calibdb.access import plans
from calibdb.access.plans import HOUR_S
from calibdb.store.ports import Item, ItemStore

_SHARE_EXPIRY_S = 2 * HOUR_S  # after the hour's end; DynamoDB removes what expired within a day or two
_DAY_S = 24 * HOUR_S
USE_DAYS = 30
_USE_EXPIRY_S = (USE_DAYS + 1) * _DAY_S
_ISSUED_TO_ALL = "ISSUED#all"
SHARDS = 8
MIN_SHARDED_LIMIT = 20_000
"""Limit per hour from which on a counter is split: fewer calls come at six a second, on average."""


class Quotas(ItemStore):
    """Counters of the current hour and of the last days; they are also the statistics of use."""

    def take(
        self, token_id: str, kind: plans.Counter, now: int, limit: int, contributor: str = ""
    ) -> int | None:
        """Count one more and return the count; None, and nothing counted, if `limit` is reached.

        `contributor`: whose share it is; empty: the token's. The limit is exact. The count of a split counter
        is an estimate: that of one part, times their number.
        """
        if contributor or limit < MIN_SHARDED_LIMIT:
            return self._add(token_id, kind, now, limit, contributor)
        first = randrange(SHARDS)  # noqa: S311
        for shard in ((first + n) % SHARDS for n in range(SHARDS)):
            part = limit // SHARDS + (shard < limit % SHARDS)
            used = self._add(token_id, kind, now, part, shard=shard)
            if used is not None:
                return min(limit, used * SHARDS)
        return None

    def add(self, token_id: str, kind: plans.Counter, now: int, amount: int) -> int:
        """Count what has happened already; return the count."""
        return self._add(token_id, kind, now, None, amount=amount) or 0

    def use(self, token_id: str, now: int) -> Mapping[str, Mapping[str, int]]:
        """Counts of a token by hour (`2026-11-22T16`, UTC) for the last 30 days."""
        oldest = hour_text(now - USE_DAYS * _DAY_S)
        hours: defaultdict[str, Counter[str]] = defaultdict(Counter)
        for shard in range(SHARDS):
            for item in self._table.query(_pk(token_id, shard), "QUOTA#"):
                hour, counts = _counts(item)
                if hour >= oldest:
                    hours[hour].update(counts)
        return dict(sorted(hours.items()))

    def used(self, token_id: str, now: int, contributor: str = "") -> Mapping[str, int]:
        """Counts of this hour, the token's or a contributor's."""
        shards = [_shard(contributor)] if contributor else range(SHARDS)
        total: Counter[str] = Counter()
        for shard in shards:
            item = self._table.get(_pk(token_id, shard), _sk(now, contributor), consistent=False)
            total.update(_counts(item)[1] if item else {})
        return total

    def take_token(self, source: str, now: int, limit: int) -> bool:
        """Count a new token of a source; False, and nothing counted, if the day's are used up."""
        day = time.strftime("%Y-%m-%d", time.gmtime(now))
        ttl = now - now % _DAY_S + 2 * _DAY_S
        if self._table.add(f"ISSUED#{source}", f"DAY#{day}", "tokens", 1, limit=limit, ttl=ttl) is None:
            return False
        self._table.add(_ISSUED_TO_ALL, f"DAY#{day}", "tokens", 1, ttl=now + _USE_EXPIRY_S)
        return True

    def issued(self) -> Iterator[tuple[str, int]]:
        """Yield days and numbers of tokens that people made for themselves."""
        for item in self._table.query(_ISSUED_TO_ALL, "DAY#"):
            yield item["sk"].removeprefix("DAY#"), item["tokens"]

    def _add(
        self,
        token_id: str,
        kind: plans.Counter,
        now: int,
        limit: int | None,
        contributor: str = "",
        shard: int | None = None,
        amount: int = 1,
    ) -> int | None:
        expiry_s = _SHARE_EXPIRY_S if contributor else _USE_EXPIRY_S
        return self._table.add(
            _pk(token_id, _shard(contributor) if shard is None else shard),
            _sk(now, contributor),
            kind,
            amount,
            limit=limit,
            ttl=now - now % HOUR_S + HOUR_S + expiry_s,
        )


def hour_text(now: int) -> str:
    """Hour of a unix time: `2026-11-22T16`, UTC."""
    return time.strftime("%Y-%m-%dT%H", time.gmtime(now))


def _pk(token_id: str, shard: int) -> str:
    return f"TOKEN#{token_id}#{shard}" if shard else f"TOKEN#{token_id}"


def _shard(contributor: str) -> int:
    return crc32(contributor.encode()) % SHARDS


def _sk(now: int, contributor: str) -> str:
    return f"SHARE#{hour_text(now)}#{contributor}" if contributor else f"QUOTA#{hour_text(now)}"


def _counts(item: Item) -> tuple[str, dict[str, int]]:
    counts = {name: value for name, value in item.items() if isinstance(value, int) and name != "ttl"}
    return item["sk"].split("#")[1], counts
