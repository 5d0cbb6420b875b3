"""Tokens that people make for themselves."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from secrets import token_hex

from calibdb.access.plans import HOUR_S, TRIAL_PERIOD_S
from calibdb.access.tokens import ApiToken, secret_hash, with_origins, with_proved, with_secret
from calibdb.errors import ForbiddenError, TooManyError
from calibdb.schema import TokenChange, TokenCreated, TokenRequest
from calibdb.schema.managed_token import ProofAnswer, ProofFailure, TokenFacts
from calibdb.store.store import Store

SECRET_BYTES = 24
_ID_BYTES = 8
_DAY_S = 24 * HOUR_S
_VERIFIERS = 10  # origins of a token that are verified at the same time


@dataclass(frozen=True)
class CreatedToken:
    """A new token and its two secrets, which are shown once."""

    token: ApiToken
    secret: str
    management: str

    def answer(self, facts: TokenFacts) -> TokenCreated:
        """Facts of the token with its secrets."""
        token_id = self.token.id
        secrets = f"cdb_{token_id}_{self.secret}", f"cdbm_{token_id}_{self.management}"
        return TokenCreated(**dict(facts), token=secrets[0], management_token=secrets[1])


def create(store: Store, request: TokenRequest, sender: str, now: int, limit: int) -> CreatedToken:
    """Create a token, `limit` per sender and day; raises ForbiddenError if that is 0, else TooManyError."""
    if limit == 0:
        raise ForbiddenError(
            "The operator of this service issues its API tokens; ask them for one.", kind="tokens-closed"
        )
    if not store.quotas.take_token(sender, now, limit):
        raise TooManyError(
            _DAY_S - now % _DAY_S,
            f"At most {limit} new tokens a day are made for one source; a token you have can be given other "
            "origins with PATCH /v1/tokens/self.",
        )
    while True:
        token_id = token_hex(_ID_BYTES)
        secret, management = token_hex(SECRET_BYTES), token_hex(SECRET_BYTES)
        token = ApiToken(
            token_id,
            secret_hash(secret),
            created=now,
            management_sha256=secret_hash(management),
            name=request.name or "",
            expires=now + TRIAL_PERIOD_S,
        )
        token = with_origins(token, request.origins)
        if store.tokens.create(token):
            return CreatedToken(token, secret, management)


def look_for_proofs(store: Store, token: ApiToken, now: int) -> tuple[ApiToken, dict[str, ProofFailure]]:
    """Look for the proofs of the pending origins; return the token and the failures by origin.

    Raises ForbiddenError if the token is revoked.
    """

    def look_for(origin: str) -> ProofAnswer:
        return store.proofs.fetch(token.id, origin, now)

    with ThreadPoolExecutor(_VERIFIERS) as verifiers:
        answers = zip(token.pending, verifiers.map(look_for, token.pending), strict=True)
        failures = {origin: one.failure for origin, one in answers if one.failure is not None}
    proved = set(token.pending) - set(failures)
    if not proved:
        return token, failures
    return _update(store, token, lambda known: with_proved(known, proved)), failures


def change(store: Store, token: ApiToken, request: TokenChange) -> ApiToken:
    """Give a token other origins or another name; raises ForbiddenError if it is revoked."""

    def changed(known: ApiToken) -> ApiToken:
        if request.origins is not None:
            known = with_origins(known, request.origins)
        return known if request.name is None else replace(known, name=request.name)

    return _update(store, token, changed)


def rotate(store: Store, token: ApiToken, secret: str, now: int, grace_s: int) -> ApiToken:
    """Give a token another secret; raises ForbiddenError if it is revoked."""
    return _update(store, token, lambda known: with_secret(known, secret_hash(secret), now, grace_s))


def require_living(token: ApiToken, now: int) -> ApiToken:
    """Token; raises ForbiddenError if it is revoked or has expired."""
    if token.revoked is not None:
        raise _revoked()
    if token.is_expired(now):
        raise ForbiddenError("The token has expired: it was not used within 30 days.", kind="token-expired")
    return token


def _update(store: Store, token: ApiToken, change: Callable[[ApiToken], ApiToken]) -> ApiToken:
    updated = store.tokens.update(token.id, change)
    if updated is None:
        raise _revoked()
    return updated


def _revoked() -> ForbiddenError:
    return ForbiddenError("The token was revoked; make a new one.", kind="token-revoked")
