"""Tokens: people make API tokens for themselves, prove their origins, watch their use, rotate and revoke.

Nothing here depends on what others have: an origin may have any number of tokens, each proved by a line of
its own, and no answer tells whether there are any.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from starlette.responses import Response

from calibdb.access import token_use
from calibdb.access.plans import HOUR_S, MAX_PROOF_CALLS, TRIAL_PERIOD_S
from calibdb.access.token_cache import retry_after
from calibdb.access.token_facts import facts, hourly_limits
from calibdb.access.tokens import ApiToken, secret_hash, source, with_secret
from calibdb.errors import ForbiddenError, TooManyError
from calibdb.http import application
from calibdb.schema import (
    ManagedToken,
    RotationRequest,
    TokenChange,
    TokenCreated,
    TokenRequest,
    TokenRotated,
    UsageAnswer,
)
from calibdb.schema.managed_token import ProofAnswer, ProofFailure, UseCounts
from calibdb.schema.origins import is_loopback

_ID_BYTES, _SECRET_BYTES = 8, 24
_DAY_S = 24 * HOUR_S
_VERIFIERS = 10  # origins of a token that are looked at side by side


def create(call: application.Call) -> Response:
    """Make a token; both of its secrets are shown this once."""
    call.require_json_of_the_site()
    request = call.json(TokenRequest)
    service = call.service
    now, limit = service.now, service.settings.max_new_tokens
    if limit == 0:
        raise ForbiddenError(
            "The operator of this service issues its API tokens; ask them for one.", kind="tokens-closed"
        )
    sender = source(service.settings.contributor_secret, call.address)
    if not service.store.quotas.take_token(sender, now, limit):
        raise TooManyError(
            _DAY_S - now % _DAY_S,
            f"At most {limit} new tokens a day are made for one source; a token you have can be given other "
            "origins with PATCH /v1/tokens/self.",
        )
    while True:
        token_id = service.random_hex(_ID_BYTES)
        secret, management = service.random_hex(_SECRET_BYTES), service.random_hex(_SECRET_BYTES)
        token = ApiToken(
            token_id,
            secret_hash(secret),
            created=now,
            management_sha256=secret_hash(management),
            name=request.name or "",
            expires=now + TRIAL_PERIOD_S,
        )
        token = _with_origins(token, request.origins)
        if service.store.tokens.create(token):
            break
    shown = facts(token, service.plan_of(token), now)
    answer = TokenCreated(
        **dict(shown), token=f"cdb_{token_id}_{secret}", management_token=f"cdbm_{token_id}_{management}"
    )
    return application.json_response(answer, 201)


def show(call: application.Call) -> Response:
    """Answer with the token's facts and use."""
    return _token_response(call, _living(call))


def change(call: application.Call) -> Response:
    """Give the token other origins or another name; an origin that it keeps stays as it is."""
    token = _living(call)
    request = call.json(TokenChange)

    def changed(known: ApiToken) -> ApiToken:
        if request.origins is not None:
            known = _with_origins(known, request.origins)
        return known if request.name is None else replace(known, name=request.name)

    return _token_response(call, _require_valid(call.service.store.tokens.update(token.id, changed)))


def verify(call: application.Call) -> Response:
    """Look for the proofs of all origins that are pending; again is answered by how it is by now."""
    token = _living(call)
    service = call.service
    failures: dict[str, ProofFailure] = {}
    if token.pending:
        service.limit_management(token, "proofs", MAX_PROOF_CALLS)

        def look_for(origin: str) -> ProofAnswer:
            return service.store.proofs.fetch(token.id, origin, service.now)

        with ThreadPoolExecutor(_VERIFIERS) as verifiers:
            answers = dict(zip(token.pending, verifiers.map(look_for, token.pending), strict=True))
        failures = {origin: one.failure for origin, one in answers.items() if one.failure is not None}
        proved = set(answers) - set(failures)
        if proved:
            token = _require_valid(
                service.store.tokens.update(token.id, lambda known: _with_proved(known, proved))
            )
    return _token_response(call, token, failures)


def rotate(call: application.Call) -> Response:
    """Give the token another secret, shown this once; the one until now opens for a while more."""
    token = _living(call)
    request = call.json(RotationRequest) if call.body else RotationRequest()
    now, secret = call.service.now, call.service.random_hex(_SECRET_BYTES)
    rotated = _require_valid(
        call.service.store.tokens.update(
            token.id, lambda known: with_secret(known, secret_hash(secret), now, request.grace_s)
        )
    )
    answer = TokenRotated(
        id=token.id, token=f"cdb_{token.id}_{secret}", former_until=rotated.former_until or None
    )
    return application.json_response(answer)


def revoke(call: application.Call) -> Response:
    """Refuse the token from now on, for good; again is answered again."""
    call.service.store.tokens.revoke(call.managed_token(), call.service.now)
    return application.no_content()


def usage(call: application.Call) -> Response:
    """Answer with the use of the API token in this hour."""
    token = call.api_token()
    service, now = call.service, call.service.now
    allowed = service.plan_of(token)
    who = service.contributor(call.address, token.id)
    answer = UsageAnswer(
        plan=token.plan,
        period_s=HOUR_S,
        resets_at=now + retry_after(now),
        limits=hourly_limits(allowed),
        used=UseCounts.model_validate(service.store.quotas.used(token.id, now)),
        used_here=UseCounts.model_validate(service.store.quotas.used(token.id, now, who)),
    )
    return application.json_response(answer)


def _living(call: application.Call) -> ApiToken:
    token = call.managed_token()
    if token.revoked is not None:
        raise ForbiddenError("The token was revoked; make a new one.", kind="token-revoked")
    if token.is_expired(call.service.now):
        raise ForbiddenError("The token has expired: it was not used within 30 days.", kind="token-expired")
    return token


def _require_valid(token: ApiToken | None) -> ApiToken:
    if token is None:
        raise ForbiddenError("The token was revoked; make a new one.", kind="token-revoked")
    return token


def _token_response(
    call: application.Call, token: ApiToken, failures: dict[str, ProofFailure] | None = None
) -> Response:
    now = call.service.now
    shown = facts(token, call.service.plan_of(token), now, failures)
    use = token_use.summary(call.service.store.quotas.use(token.id, now), now)
    return application.json_response(ManagedToken(**dict(shown), use=use))


def _with_origins(token: ApiToken, origins: tuple[str, ...]) -> ApiToken:
    """Return the token with these origins; those of the machine itself and those proved before are proved."""
    verified = tuple(o for o in origins if is_loopback(o) or o in token.origins)
    pending = tuple(o for o in origins if o not in verified)
    return _with_plan(replace(token, origins=verified, pending=pending))


def _with_proved(token: ApiToken, proved: set[str]) -> ApiToken:
    """Return the token with those of its pending origins verified that were proved."""
    now_verified = tuple(origin for origin in token.pending if origin in proved)
    left = tuple(origin for origin in token.pending if origin not in proved)
    return _with_plan(replace(token, origins=(*token.origins, *now_verified), pending=left))


def _with_plan(token: ApiToken) -> ApiToken:
    """Return the token with the plan that its origins earn it; one that the operator gave it stays."""
    if token.plan not in ("trial", "free"):
        return token
    proved = any(not is_loopback(origin) for origin in token.origins)
    return replace(token, plan="free", expires=None) if proved else replace(token, plan="trial")


handler = application.handler(
    application.route("/v1/tokens", POST=create),
    application.route("/v1/tokens/self", GET=show, PATCH=change, DELETE=revoke),
    application.route("/v1/tokens/self/verify", POST=verify),
    application.route("/v1/tokens/self/rotate", POST=rotate),
    application.route("/v1/usage", GET=usage),
)
