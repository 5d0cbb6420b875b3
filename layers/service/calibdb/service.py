"""What a handler works with: settings, clock, credentials, storage, put together once for an environment."""

from __future__ import annotations

import functools
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from calibdb.access.plans import Kind, plan
from calibdb.access.token_cache import TokenMemory, retry_after
from calibdb.access.tokens import ApiToken, SessionIds, Ticket, contributor, matches, parse
from calibdb.errors import ForbiddenError, TooManyError
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
    _tokens: TokenMemory

    @classmethod
    def of(cls, environment: Mapping[str, str]) -> Service:
        """Return the service of `environment`; one and the same for equal settings."""
        return _service(Settings.from_environment(with_secrets(environment)))

    @classmethod
    def build(
        cls,
        settings: Settings,
        store: Store,
        clock: Callable[[], float] = time.time,
        random_hex: Callable[[int], str] = secrets.token_hex,
    ) -> Service:
        """Put a service together from its parts."""
        ids = SessionIds(settings.session_secrets, clock)
        return cls(settings, store, ids, clock, random_hex, TokenMemory(store.tokens, store.quotas, clock))

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
            raise ForbiddenError("The API token that opened this session is not valid any more.")
        return token

    def contributor(self, address: str, token_id: str) -> str:
        """Return who asks, as a keyed hash."""
        return contributor(self.settings.contributor_secret, address, token_id)

    def count_lookup(self, token: ApiToken, address: str) -> None:
        """Count a read with an API token, in memory; raises TooManyError."""
        self._tokens.count_lookup(token, address)

    def charge(self, token: ApiToken, kind: Kind, address: str) -> None:
        """Count a call against this hour's share of the contributor, then of all; raises TooManyError.

        In this order, so that who has used up their own share takes nothing from the others any more.
        """
        allowed = plan(token.plan)
        now = self.now
        for limit, who in (
            (getattr(allowed.each, kind), self.contributor(address, token.id)),
            (getattr(allowed.together, kind), ""),
        ):
            if limit is not None and not self.store.quotas.take(token.id, kind, now, limit, who):
                raise TooManyError(retry_after(now))


@functools.lru_cache(maxsize=8)
def _service(settings: Settings) -> Service:
    return Service.build(settings, Store.of(settings))
