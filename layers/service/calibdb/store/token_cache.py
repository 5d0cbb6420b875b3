"""TTL cache of API tokens, which also counts their lookups without a write for each.

A lookup that hits is one Query. So its token is cached for half a minute, and lookups are counted in memory
and flushed when the token is read again: once for some hundred lookups, or after some minutes. A function
that is ended loses what it had not written.
"""

import threading
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from calibdb.access.plans import (
    HOUR_S,
    NETWORK_SHARES,
    PLANS,
    Plan,
    RateLimit,
    plan,
    rate_limit_headers,
)
from calibdb.access.tokens import ApiToken
from calibdb.errors import TooManyError, UnavailableError
from calibdb.store.quotas import Quotas
from calibdb.store.tokens import Tokens

# Seconds for which a token is remembered. The edge keeps answers to GET lookups for 20 more: together less
# than the minute after which a revoked token opens nothing any more.
TOKEN_TTL_S = 30.0
REFUSAL_TTL_S = 1.0  # seconds for which a token that was just read is not read again for a wrong secret
LOOKUPS_PER_FLUSH = 250
FLUSH_INTERVAL_S = 600.0  # after which fewer lookups are also flushed
_MAX_TOKENS = 1024
_MAX_SOURCES = 4096  # of one token and hour


@dataclass
class _Entry:
    token: ApiToken
    read_again: float  # unix seconds
    flushed: float  # unix seconds
    refused_until: float = 0.0  # unix seconds; until then a wrong secret does not read the token again
    pending: Counter[int] = field(default_factory=Counter)  # lookups since `flushed`, by hour
    next_flush: float = 0.0  # unix seconds, after a failure
    hour: int = 0
    used: int = 0  # lookups of this hour by all instances, as last flushed
    sources: Counter[int] = field(default_factory=Counter)  # lookups of this hour
    reading: threading.Lock = field(default_factory=threading.Lock)

    def is_full(self, now: float, plans: Mapping[str, Plan]) -> bool:
        lookups = sum(self.pending.values())
        return lookups >= _lookups_per_flush(plan(self.token.plan, plans)) and now >= self.next_flush

    def is_due(self, now: float, plans: Mapping[str, Plan]) -> bool:
        if not self.pending or now < self.next_flush:
            return False
        is_old = now - self.flushed >= FLUSH_INTERVAL_S or min(self.pending) < int(now // HOUR_S)
        return is_old or self.is_full(now, plans)


class TokenCache:
    """Tokens that one instance of a function read lately. Thread-safe.

    `in_background`: lookups and first uses are stored by `write_pending`, which a server calls every second.
    """

    def __init__(
        self,
        tokens: Tokens,
        quotas: Quotas,
        clock: Callable[[], float],
        ttl_s: float = TOKEN_TTL_S,
        plans: Mapping[str, Plan] = PLANS,
        *,
        in_background: bool = False,
    ) -> None:
        self._tokens = tokens
        self._quotas = quotas
        self._clock = clock
        self._ttl_s = ttl_s
        self._plans = plans
        self._in_background = in_background
        self._known: dict[str, _Entry] = {}
        self._used_first: set[str] = set()  # ids of tokens whose first use is not written down yet
        self._lock = threading.Lock()

    def get(self, token_id: str, accepts: Callable[[ApiToken], bool] = lambda _: True) -> ApiToken | None:
        """Token as it was at most half a minute ago.

        A remembered token that `accepts` refuses, since its secret is another one, is read again: it may have
        been rotated. While that does not help, it is read once in `REFUSAL_TTL_S`.
        """
        entry = self._known.get(token_id)
        if entry is None:
            return self._read(token_id, accepts)
        if token := self._current(token_id, accepts):
            return token
        with entry.reading:  # of many waiting threads only the first reads
            return self._current(token_id, accepts) or self._read(token_id, accepts)

    def _current(self, token_id: str, accepts: Callable[[ApiToken], bool]) -> ApiToken | None:
        now = self._clock()
        with self._lock:
            entry = self._known.get(token_id)
            if entry is None or now >= entry.read_again:
                return None
            if not self._in_background and entry.is_full(now, self._plans):
                return None
            return entry.token if now < entry.refused_until or accepts(entry.token) else None

    def _read(self, token_id: str, accepts: Callable[[ApiToken], bool]) -> ApiToken | None:
        now, token = self._clock(), self._tokens.get(token_id)
        with self._lock:
            if token is None:
                self._known.pop(token_id, None)
                return None
            entry = self._known.get(token_id)
            if entry is None:
                if len(self._known) >= _MAX_TOKENS:
                    self._known.clear()
                entry = self._known[token_id] = _Entry(token, now, flushed=now)
            entry.token, entry.read_again = token, now + self._ttl_s
            entry.refused_until = 0.0 if accepts(token) else now + REFUSAL_TTL_S
        if not self._in_background:
            self._flush(entry, now)
        return token

    def keep(self, token: ApiToken) -> None:
        """Note the first use of a token, so that it does not expire."""
        if token.expires is None:
            return
        with self._lock:
            entry = self._known.get(token.id)
            if entry is not None and entry.token.expires is None:
                return
            if self._in_background:
                self._used_first.add(token.id)
        if not self._in_background:
            try:
                self._tokens.keep(token.id)
            except UnavailableError:  # no reason to refuse; the next use notes it
                return
        if entry is not None:
            with self._lock:
                entry.token = replace(entry.token, expires=None)

    def count_lookup(self, token: ApiToken, source: str, network: str | None = None) -> tuple[RateLimit, ...]:
        """Count a lookup from `source` on the line `network`; raises TooManyError if they are used up."""
        allowed = plan(token.plan, self._plans)
        together, each = allowed.together.lookups, allowed.each.lookups
        if together is None:
            return ()
        now = self._clock()
        with self._lock:
            entry = self._known.get(token.id)
            if entry is None:  # it was one of too many
                return ()
            if entry.hour != int(now // HOUR_S):
                entry.hour, entry.used = int(now // HOUR_S), 0
                entry.sources.clear()
            # Hashes differ from process to process: no address is kept.
            shares = {hash(source): 1} | ({} if network is None else {hash((network,)): NETWORK_SHARES})
            own = entry.sources[hash(source)]
            left_together = together - entry.used - entry.pending[entry.hour]
            is_used_up = (left_together if self._in_background else together - entry.used) <= 0
            if is_used_up or (
                each is not None and any(entry.sources[who] >= share * each for who, share in shares.items())
            ):
                limits = _limits(now, (each, 0), (together, left_together))
                raise TooManyError(retry_after(now), headers=rate_limit_headers(limits))
            if len(entry.sources) + len(shares) > _MAX_SOURCES:
                entry.sources.clear()
            entry.sources.update(shares.keys())
            entry.pending[entry.hour] += 1
        if allowed.counts_each_lookup and not self._in_background:
            self._flush(entry, now)
        return _limits(now, (each, 0 if each is None else each - own - 1), (together, left_together - 1))

    def write_pending(self) -> None:
        """Store all lookups and first uses that were counted since the last time."""
        with self._lock:
            entries = list(self._known.values())
            used_first = list(self._used_first)
        for token_id in used_first:
            self._tokens.keep(token_id)  # if that fails, it is written the next time
            with self._lock:
                self._used_first.discard(token_id)
        for entry in entries:
            self._flush(entry, self._clock())

    def _flush(self, entry: _Entry, now: float) -> None:
        with self._lock:
            is_due = entry.pending and now >= entry.next_flush
            if not (is_due if self._in_background else entry.is_due(now, self._plans)):
                return
            pending, entry.pending, entry.flushed = entry.pending, Counter(), now
        hour = int(now // HOUR_S)
        while pending:
            past, lookups = pending.popitem()
            try:
                used = self._quotas.add(entry.token.id, "lookups", past * HOUR_S, lookups)
            except UnavailableError:  # no reason to refuse a lookup
                pending[past] = lookups
                with self._lock:
                    entry.pending.update(pending)
                    entry.next_flush = now + self._ttl_s
                return
            if past == hour:
                with self._lock:
                    entry.hour, entry.used = hour, used


def retry_after(now: float) -> int:
    """Seconds until the next hour begins."""
    return HOUR_S - int(now) % HOUR_S


def _limits(now: float, each: tuple[int | None, int], together: tuple[int, int]) -> tuple[RateLimit, ...]:
    """Limits of one user and of all: pairs of a quota, None without a bound, and what is left."""
    named = (("lookups-each", *each), ("lookups", *together))
    return tuple(
        RateLimit(name, limit, left, retry_after(now)) for name, limit, left in named if limit is not None
    )


def _lookups_per_flush(allowed: Plan) -> int:
    limit = allowed.together.lookups
    if allowed.counts_each_lookup:
        return 1
    return LOOKUPS_PER_FLUSH if limit is None else max(1, min(LOOKUPS_PER_FLUSH, limit // 20))
