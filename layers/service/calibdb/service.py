"""What a handler works with: settings, clock, credentials, storage, put together once for an environment."""

from __future__ import annotations

import functools
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from calibdb.errors import ForbiddenError
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.tokens import ApiToken, SessionIds, Ticket, matches, parse

TOKEN_MEMORY = 60.0  # seconds after which a revoked token is refused
_MOST_TOKENS = 1024


@dataclass(frozen=True)
class Service:
    """One function's view of the world."""

    settings: Settings
    store: Store
    session_ids: SessionIds
    clock: Callable[[], float]
    random_hex: Callable[[int], str]  # of so many bytes
    _known_tokens: dict[str, tuple[ApiToken, float]]

    @classmethod
    def of(cls, environment: Mapping[str, str]) -> Service:
        """Return the service of `environment`; one and the same for equal settings."""
        return _service(Settings.from_environment(environment))

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
        return cls(settings, store, ids, clock, random_hex, {})

    @property
    def now(self) -> int:
        """Unix time, whole seconds."""
        return int(self.clock())

    def ticket(self, token: ApiToken, origin: str | None) -> Ticket:
        """Return a new session's ticket. Session names sort by the time of their start."""
        return Ticket(f"{self.now:08x}{self.random_hex(8)}", token.id, origin if token.origins else None)

    def api_token(self, text: str) -> ApiToken:
        """Return the token that `text` is; raises ForbiddenError when it is unknown or its secret is wrong.

        A token once read is remembered for a minute: a lookup then costs one Query and nothing else.
        """
        parts = parse(text)
        token = self._token(parts[0]) if parts else None
        if parts is None or token is None or not matches(token, parts[1]):
            raise ForbiddenError("The API token is not valid.")
        return token

    def _token(self, token_id: str) -> ApiToken | None:
        now = self.clock()
        known = self._known_tokens.get(token_id)
        if known is not None and now < known[1]:
            return known[0]
        self._known_tokens.pop(token_id, None)
        token = self.store.tokens.get(token_id)
        if token is not None:
            if len(self._known_tokens) >= _MOST_TOKENS:
                self._known_tokens.clear()
            self._known_tokens[token_id] = (token, now + TOKEN_MEMORY)
        return token


@functools.lru_cache(maxsize=8)
def _service(settings: Settings) -> Service:
    return Service.build(settings, Store.of(settings))
