"""Service of a handler: settings, clock, credentials and storage."""

from __future__ import annotations

import functools
import logging
import os
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from calibdb.access.plans import (
    MAX_MANAGEMENT_CALLS,
    NETWORK_SHARES,
    Counter,
    Kind,
    Plan,
    RateLimit,
    multiplied,
    plan,
    rate_limit_headers,
)
from calibdb.access.tokens import (
    ApiToken,
    SessionIds,
    Ticket,
    contributor,
    manages,
    matches,
    network,
    parse,
    source,
)
from calibdb.errors import ForbiddenError, TooManyError
from calibdb.lookup.reports import AliasFilter, MissCounter
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.secrets import with_secrets
from calibdb.store.token_cache import TOKEN_TTL_S, TokenCache, retry_after

WRITE_INTERVAL_S = 1.0  # of what no response waits for, in a server

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Service:
    """One function's view of the world."""

    settings: Settings
    store: Store
    session_ids: SessionIds
    clock: Callable[[], float]
    _tokens: TokenCache
    _plans: Mapping[str, Plan]
    aliases: AliasFilter = field(default_factory=AliasFilter, compare=False)
    misses: MissCounter = field(default_factory=MissCounter, compare=False)
    _writes: deque[Callable[[], None]] | None = field(default=None, compare=False)

    @classmethod
    def of_process(cls) -> Service:
        """Service of this process, one for equal settings.

        The environment is read once, secrets again every five minutes.
        """
        global _settings, _settings_until
        settings = _settings
        if settings is None or time.monotonic() >= _settings_until:
            variables, until = with_secrets(os.environ)
            settings = Settings.from_environment(variables)
            _settings, _settings_until = settings, until
        return _maker(settings)

    @classmethod
    @contextmanager
    def in_server(cls) -> Iterator[None]:
        """Have `of_process` return one service within the block, with a thread for pending writes."""
        settings = Settings.from_environment(with_secrets(os.environ)[0])
        service = cls.build(settings, Store.of(settings), in_background=True)
        stopping = threading.Event()

        def work() -> None:
            while not stopping.wait(WRITE_INTERVAL_S):
                service.write_pending()

        thread = threading.Thread(target=work, name="pending writes", daemon=True)
        thread.start()
        try:
            with cls.override(lambda _: service):
                yield
        finally:
            stopping.set()
            thread.join()
            service.write_pending()

    @property
    def writes_later(self) -> bool:
        """True in a server, which calls `write_pending` once per `WRITE_INTERVAL_S`."""
        return self._writes is not None

    def write_later(self, write: Callable[[], None]) -> None:
        """Run `write` within `WRITE_INTERVAL_S` in a server, else now."""
        if self._writes is None:
            write()
        else:
            self._writes.append(write)

    def write_pending(self) -> None:
        """Write counted lookups, and what `write_later` gathered."""
        try:
            self._tokens.write_pending()
            while self._writes:
                self._writes.popleft()()
        except Exception:  # noqa: BLE001 - the rest is written the next time
            _log.exception("pending writes failed")

    @classmethod
    @contextmanager
    def override(cls, make: Callable[[Settings], Service]) -> Iterator[None]:
        """Have `of_process` return `make(settings)` within the block."""
        global _maker
        before = _maker
        _maker = make
        try:
            yield
        finally:
            _maker = before

    @classmethod
    def forget(cls) -> None:
        """Forget the environment and its services."""
        global _settings
        _settings = None
        _remembered.cache_clear()

    @classmethod
    def make(cls, settings: Settings) -> Service:
        """New service over the storage of `settings`."""
        return cls.build(settings, Store.of(settings))

    @classmethod
    def build(
        cls,
        settings: Settings,
        store: Store,
        clock: Callable[[], float] = time.time,
        token_ttl_s: float = TOKEN_TTL_S,
        plans: Mapping[str, Plan] | None = None,
        *,
        in_background: bool = False,
    ) -> Service:
        """Put a service together; `in_background`: `write_pending` is called once per `WRITE_INTERVAL_S`."""
        ids, plans = SessionIds(settings.session_secrets, clock), plans or multiplied(settings.plan_factors)
        tokens = TokenCache(
            store.tokens, store.quotas, clock, token_ttl_s, plans, in_background=in_background
        )
        writes = deque[Callable[[], None]]() if in_background else None
        return cls(settings, store, ids, clock, tokens, plans, _writes=writes)

    @property
    def now(self) -> int:
        """Unix time, whole seconds."""
        return int(self.clock())

    def ticket(self, token: ApiToken, origin: str | None) -> Ticket:
        """Ticket of a new session. Names of sessions sort by the time of their start."""
        return Ticket(
            f"{self.now:08x}{secrets.token_hex(8)}", token.id, origin if token.is_restricted else None
        )

    def api_token(self, text: str, before_write: Callable[[], None] = lambda: None) -> ApiToken:
        """Token that `text` is; raises ForbiddenError.

        Its first use is written, in a server later; else after `before_write`.
        """
        token_id, secret = parse(text) or ("", "")

        def accepts(token: ApiToken) -> bool:
            return matches(token, secret, self.clock())

        token = self._tokens.get(token_id, accepts) if token_id else None
        if token is None or not accepts(token):
            raise ForbiddenError("The API token is not valid.")
        if token.is_expired(self.clock()):
            raise ForbiddenError(
                "The API token has expired: it was not used within 30 days. Make a new one.",
                kind="token-expired",
            )
        if token.expires is not None:
            if not self.writes_later:
                before_write()
            self._tokens.keep(token)
        return token

    def managed_token(self, text: str) -> ApiToken:
        """Token, revoked or not, that the management token `text` manages, as the bucket has it.

        ForbiddenError is the same, and as fast, for unknown tokens and wrong secrets.
        """
        parts = parse(text, "cdbm")
        token = self.store.tokens.read(parts[0]) if parts else None
        if parts is None or not manages(token, parts[1]) or token is None:
            raise ForbiddenError("The management token is not valid.")
        return token

    def limit_management(
        self, token: ApiToken, counter: Counter = "management", limit: int = MAX_MANAGEMENT_CALLS
    ) -> None:
        """Count a call that manages the token; raises TooManyError."""
        if not self.store.quotas.take(token.id, counter, self.now, limit):
            raise TooManyError(
                retry_after(self.now),
                f"At most {limit} such calls are allowed in an hour; retry after the time in Retry-After.",
            )

    def plan_of(self, token: ApiToken) -> Plan:
        """Limits of a token."""
        return plan(token.plan, self._plans)

    def token_of(self, ticket: Ticket) -> ApiToken:
        """Token that opened a session; raises ForbiddenError."""
        token = self._tokens.get(ticket.token)
        if token is None:
            raise ForbiddenError("The API token that opened this session is no longer valid.")
        return token

    def contributor(self, address: str, token_id: str) -> str:
        """Contributor of a request, as a keyed hash."""
        return contributor(self.settings.contributor_secret, address, token_id)

    def source(self, address: str) -> str:
        """Source of a request, whatever its token, as a keyed hash."""
        return source(self.settings.contributor_secret, address)

    def count_lookup(self, token: ApiToken, address: str) -> tuple[RateLimit, ...]:
        """Count a read in memory, and return what is left; raises TooManyError."""
        return self._tokens.count_lookup(token, *self._shares(token, address))

    def charge(self, token: ApiToken, kind: Kind, address: str) -> tuple[RateLimit, ...]:
        """Count a call against this hour's share of the contributor, of their line, of all; TooManyError.

        An exhausted contributor takes nothing from the others.
        """
        allowed, now = self.plan_of(token), self.now
        each, together = getattr(allowed.each, kind), getattr(allowed.together, kind)
        who, line = self._shares(token, address)
        limits = [(each, who), (together, "")]
        if line is not None and each is not None:
            limits.insert(1, (NETWORK_SHARES * each, line))
        left: list[RateLimit] = []
        for limit, name in limits:
            if limit is None:
                continue
            used = self.store.quotas.take(token.id, kind, now, limit, name)
            policy = f"{kind}-each" if name else kind
            if not used:
                exhausted = RateLimit(policy, limit, 0, retry_after(now))
                raise TooManyError(retry_after(now), headers=rate_limit_headers([*left, exhausted]))
            if name != line:
                left.append(RateLimit(policy, limit, limit - used, retry_after(now)))
        return tuple(left)

    def _shares(self, token: ApiToken, address: str) -> tuple[str, str | None]:
        """Keyed hashes of a contributor and, of IPv6, of their line."""
        secret = self.settings.contributor_secret
        return self.contributor(address, token.id), network(secret, address, token.id)


_settings: Settings | None = None
_settings_until = 0.0  # at which secrets are read again, by `time.monotonic`
_remembered = functools.lru_cache(maxsize=8)(Service.make)
_maker: Callable[[Settings], Service] = _remembered
