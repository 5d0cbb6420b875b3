"""Service context of a handler: settings, clock, credentials, storage, built once for an environment."""

from __future__ import annotations

import functools
import secrets
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from calibdb.access.plans import NETWORK_SHARES, PLANS, Kind, Plan, plan
from calibdb.access.token_cache import TOKEN_TTL_S, TokenCache, retry_after
from calibdb.access.tokens import ApiToken, SessionIds, Ticket, contributor, matches, network, parse
from calibdb.errors import ForbiddenError, TooManyError
from calibdb.lookup.sightings import SightingFilter
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.secrets import with_secrets


@dataclass(frozen=True)
class Service:
    """One function's view of the world."""

    settings: Settings
    store: Store
    session_ids: SessionIds
    clock: Callable[[], float]
    random_hex: Callable[[int], str]  # of so many bytes
    _tokens: TokenCache
    _plans: Mapping[str, Plan]
    sightings: SightingFilter = field(default_factory=SightingFilter, compare=False)

    @classmethod
    def of(cls, environment: Mapping[str, str]) -> Service:
        """Return the service of `environment`; one and the same for equal settings."""
        return _maker(Settings.from_environment(with_secrets(environment)))

    @classmethod
    @contextmanager
    def override(cls, make: Callable[[Settings], Service]) -> Iterator[None]:
        """Have `of` return `make(settings)` within the block, in every thread.

        For tests and measurements: a function's service with another clock or cache. `make` is called for
        each request; a service that lasts is for `make` to keep.
        """
        global _maker
        before = _maker
        _maker = make
        try:
            yield
        finally:
            _maker = before

    @classmethod
    def build(
        cls,
        settings: Settings,
        store: Store,
        clock: Callable[[], float] = time.time,
        random_hex: Callable[[int], str] = secrets.token_hex,
        token_ttl_s: float = TOKEN_TTL_S,
        plans: Mapping[str, Plan] = PLANS,
    ) -> Service:
        """Put a service together from its parts."""
        ids = SessionIds(settings.session_secrets, clock)
        tokens = TokenCache(store.tokens, store.quotas, clock, token_ttl_s, plans)
        return cls(settings, store, ids, clock, random_hex, tokens, plans)

    @property
    def now(self) -> int:
        """Unix time, whole seconds."""
        return int(self.clock())

    def ticket(self, token: ApiToken, origin: str | None) -> Ticket:
        """Return a new session's ticket. Session names sort by the time of their start."""
        return Ticket(f"{self.now:08x}{self.random_hex(8)}", token.id, origin if token.origins else None)

    def api_token(self, text: str) -> ApiToken:
        """Return the token that `text` is; raises ForbiddenError when it is unknown or its secret is wrong.

        A token once read is remembered for half a minute: a lookup then costs one Query and nothing else.
        """
        parts = parse(text)
        token = self._tokens.get(parts[0]) if parts else None
        if parts is None or token is None or not matches(token, parts[1], self.clock()):
            raise ForbiddenError("The API token is not valid.")
        return token

    def token_of(self, ticket: Ticket) -> ApiToken:
        """Return the token that opened a session; raises ForbiddenError once it is revoked."""
        token = self._tokens.get(ticket.token)
        if token is None:
            raise ForbiddenError("The API token that opened this session is no longer valid.")
        return token

    def contributor(self, address: str, token_id: str) -> str:
        """Contributor of a request, as a keyed hash."""
        return contributor(self.settings.contributor_secret, address, token_id)

    def count_lookup(self, token: ApiToken, address: str) -> None:
        """Count a read with an API token, in memory; raises TooManyError."""
        self._tokens.count_lookup(token, *self._shares(token, address))

    def charge(self, token: ApiToken, kind: Kind, address: str) -> None:
        """Count a call against this hour's share of the contributor, of their line, of all; TooManyError.

        In this order, so that who has used up their own share takes nothing from the others any more.
        """
        allowed = plan(token.plan, self._plans)
        now = self.now
        each, together = getattr(allowed.each, kind), getattr(allowed.together, kind)
        who, line = self._shares(token, address)
        limits = [(each, who), (together, "")]
        if line is not None and each is not None:
            limits.insert(1, (NETWORK_SHARES * each, line))
        for limit, name in limits:
            if limit is not None and not self.store.quotas.take(token.id, kind, now, limit, name):
                raise TooManyError(retry_after(now))

    def _shares(self, token: ApiToken, address: str) -> tuple[str, str | None]:
        """Keyed hashes of a contributor and, of IPv6, of their line."""
        secret = self.settings.contributor_secret
        return self.contributor(address, token.id), network(secret, address, token.id)


@functools.lru_cache(maxsize=8)
def _service(settings: Settings) -> Service:
    return Service.build(settings, Store.of(settings))


_maker: Callable[[Settings], Service] = _service
