"""Tokens: people make API tokens for themselves, prove their origins, watch their use, rotate and revoke.

No response reveals whether an origin has other tokens.
"""

import secrets

from starlette.responses import Response

from calibdb.access.plans import HOUR_S, MAX_PROOF_CALLS
from calibdb.access.token_facts import facts, hourly_limits, use_summary
from calibdb.access.tokens import ApiToken
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.schema import (
    ManagedToken,
    RotationRequest,
    TokenChange,
    TokenRequest,
    TokenRotated,
    UsageAnswer,
)
from calibdb.schema.managed_token import ProofFailure, UseCounts
from calibdb.store import managed_tokens
from calibdb.store.token_cache import retry_after


def create(call: Call) -> Response:
    """Make a token."""
    call.require_json_of_the_site()
    request, service = call.json(TokenRequest), call.service
    sender, limit = service.source(call.address), service.settings.max_new_tokens
    made = managed_tokens.create(service.store, request, sender, service.now, limit)
    shown = facts(made.token, service.plan_of(made.token), service.now)
    return json_response(made.answer(shown), 201)


def show(call: Call) -> Response:
    """Show the token's facts and use."""
    return _token_response(call, _living(call))


def change(call: Call) -> Response:
    """Give the token other origins or another name."""
    token = _living(call)
    return _token_response(call, managed_tokens.change(call.store, token, call.json(TokenChange)))


def verify(call: Call) -> Response:
    """Look for the proofs of all pending origins."""
    token = _living(call)
    service = call.service
    failures: dict[str, ProofFailure] = {}
    if token.pending:
        service.limit_management(token, "proofs", MAX_PROOF_CALLS)
        token, failures = managed_tokens.look_for_proofs(service.store, token, service.now)
    return _token_response(call, token, failures)


def rotate(call: Call) -> Response:
    """Give the token another secret."""
    token, service = _living(call), call.service
    request = call.json(RotationRequest) if call.body else RotationRequest()
    secret = secrets.token_hex(managed_tokens.SECRET_BYTES)
    rotated = managed_tokens.rotate(service.store, token, secret, service.now, request.grace_s)
    answer = TokenRotated(
        id=token.id, token=f"cdb_{token.id}_{secret}", former_until=rotated.former_until or None
    )
    return json_response(answer)


def revoke(call: Call) -> Response:
    """Revoke the token for good; idempotent."""
    call.store.tokens.revoke(call.managed_token(), call.now)
    return Response(status_code=204)


def usage(call: Call) -> Response:
    """Show the use of the API token in this hour."""
    token = call.api_token()
    service, now = call.service, call.now
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
    return json_response(answer)


def _living(call: Call) -> ApiToken:
    return managed_tokens.require_living(call.managed_token(), call.now)


def _token_response(call: Call, token: ApiToken, failures: dict[str, ProofFailure] | None = None) -> Response:
    now = call.now
    shown = facts(token, call.service.plan_of(token), now, failures)
    use = use_summary(call.store.quotas.use(token.id, now), now)
    return json_response(ManagedToken(**dict(shown), use=use))


handler = application.handler(
    route("/v1/tokens", POST=create),
    route("/v1/tokens/self", GET=show, PATCH=change, DELETE=revoke),
    route("/v1/tokens/self/verify", POST=verify),
    route("/v1/tokens/self/rotate", POST=rotate),
    route("/v1/usage", GET=usage),
)
