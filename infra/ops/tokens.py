"""API tokens: creation, listing, rotation, revocation."""

import time
from collections.abc import Sequence
from secrets import token_hex
from typing import Annotated
from urllib.parse import urlsplit

import typer

from calibdb.access.plans import HOUR_S, PLANS
from calibdb.access.token_facts import use_summary
from calibdb.access.tokens import ApiToken, secret_hash, with_secret
from calibdb.schema.managed_token import TokenUse
from calibdb.store import Tokens
from infra.console import Output, confirm
from infra.ops import OpsError
from infra.ops.context import OpsContext
from infra.ops.session import DryRun, Json, Yes, open_run

app = typer.Typer(help="Issue, list, rotate and revoke API tokens.", no_args_is_help=True)
TokenId = Annotated[str, typer.Argument(metavar="ID", help="As `token list` prints it.")]
_ID_BYTES, _SECRET_BYTES = 8, 24


def issue(tokens: Tokens, origins: Sequence[str], plan: str, now: int) -> str:
    """Store a new token under a random id and return it. Only its hash is stored."""
    while True:
        token_id, secret = token_hex(_ID_BYTES), token_hex(_SECRET_BYTES)
        if tokens.create(ApiToken(token_id, secret_hash(secret), tuple(origins), plan, now)):
            return f"cdb_{token_id}_{secret}"


def list_all(context: OpsContext) -> list[ApiToken]:
    """List the tokens that work, oldest first."""
    return sorted(context.store.tokens.all(), key=lambda token: (token.created, token.id))


def describe(token: ApiToken) -> tuple[str, str, str, str, str]:
    """Describe a token: id, day, plan, creator, origins."""
    day = time.strftime("%Y-%m-%d", time.gmtime(token.created))
    made_by = "operator" if token.management_sha256 is None else "itself"
    origins = [*token.origins, *(f"{origin} (pending)" for origin in token.pending)]
    return token.id, day, token.plan, made_by, " ".join(origins) or "any origin"


def use(context: OpsContext, token_id: str) -> TokenUse:
    """Sum up the use of a token by hour and by day."""
    return use_summary(context.store.quotas.use(token_id, context.now), context.now)


def revoke(context: OpsContext, token_id: str) -> None:
    """Refuse the token from now on, for good: its id is never another's."""
    context.store.tokens.revoke(_get(context, token_id), context.now)


def _get(context: OpsContext, token_id: str) -> ApiToken:
    token = context.store.tokens.get(token_id)
    if token is None:
        raise OpsError(f"there is no token {token_id}")
    return token


def _check(origin: str) -> None:
    # RFC 6454, 6.2: scheme, host, port, as a browser writes them in the Origin header; no path, not even a
    # slash.
    parts = urlsplit(origin)
    if parts.scheme not in ("http", "https") or not parts.hostname or origin != origin.lower():
        raise OpsError(f"{origin!r} is not an origin such as https://example.org")
    if f"{parts.scheme}://{parts.netloc}" != origin or parts.username is not None:
        raise OpsError(f"{origin!r} has more than scheme, host and port")


def _complete_plan(start: str) -> list[str]:
    return [plan for plan in PLANS if plan.startswith(start)]


def _print_token(output: Output, token: str) -> None:
    output.line(token)
    output.value({"token": token})


@app.command("create")
def create_token(
    origin: Annotated[
        list[str] | None, typer.Option(help="Origin that may use the token; repeatable. None: any.")
    ] = None,
    plan: Annotated[
        str, typer.Option(help="Plan, which limits its use in an hour.", autocompletion=_complete_plan)
    ] = "free",
    as_json: Json = False,
) -> None:
    """Issue a token; it is shown once."""
    with open_run(as_json=as_json) as (context, output):
        origins = origin or []
        for one in origins:
            _check(one)
        if plan not in PLANS:
            raise OpsError(f"there is no plan {plan!r}; there are {', '.join(PLANS)}")
        _print_token(output, issue(context.store.tokens, origins, plan, context.now))


@app.command("list")
def list_tokens(as_json: Json = False) -> None:
    """List all tokens, without their secrets."""
    with open_run(as_json=as_json) as (context, output):
        listing = list_all(context)
        output.table(("id", "created", "plan", "made by", "origins"), [describe(one) for one in listing])
        output.value(
            [
                {
                    "id": token.id,
                    "created": token.created,
                    "plan": token.plan,
                    "origins": token.origins,
                    "pending": token.pending,
                    "name": token.name or None,
                    "self_made": token.management_sha256 is not None,
                    "former_until": token.former_until or None,
                }
                for token in listing
            ]
        )


@app.command("show")
def show_token(token_id: TokenId, as_json: Json = False) -> None:
    """Show a token and its use: by hour for two days, by day for thirty."""
    with open_run(as_json=as_json) as (context, output):
        token = _get(context, token_id)
        used = use(context, token_id)
        output.line("  ".join(describe(token)))
        periods = [*((one.hour, one) for one in used.hours), *((one.day, one) for one in used.days)]
        rows = [(period, one.sessions, one.views, one.poses, one.lookups) for period, one in periods]
        output.table(
            ("period (UTC)", "sessions", "views", "poses", "lookups"), [row for row in rows if any(row[1:])]
        )
        output.value({"id": token.id, "plan": token.plan, "use": used.model_dump(mode="json")})


@app.command("made")
def count_made(as_json: Json = False) -> None:
    """Count the tokens that people made for themselves, day by day."""
    with open_run(as_json=as_json) as (context, output):
        days = list(context.store.quotas.issued())
        output.table(("day (UTC)", "tokens"), days)
        output.value([{"day": day, "tokens": count} for day, count in days])


@app.command("sweep")
def sweep_tokens(dry_run: DryRun = False) -> None:
    """Remove trial tokens that expired unused, a week after their end."""
    with open_run() as (context, output):
        store = context.store.tokens
        orphans = store.orphans(context.now)
        count = len(orphans) if dry_run else store.remove(orphans)
        output.line(f"{count} trial tokens {'would be ' if dry_run else ''}removed")


@app.command("revoke")
def revoke_token(token_id: TokenId, dry_run: DryRun = False, yes: Yes = False) -> None:
    """Revoke a token for good, within a minute."""
    with open_run() as (context, output):
        description = "  ".join(describe(_get(context, token_id)))
        if dry_run:
            output.line(f"would be revoked: {description}")
            return
        confirm(f"Revoke for good: {description}?", yes=yes)
        revoke(context, token_id)


@app.command("rotate")
def rotate_token(
    token_id: TokenId,
    grace: Annotated[
        float,
        typer.Option(min=0, max=24 * 366, metavar="HOURS", help="Time for which the old secret still works."),
    ] = 24,
    dry_run: DryRun = False,
    yes: Yes = False,
    as_json: Json = False,
) -> None:
    """Give a token a new secret; it is shown once."""
    with open_run(as_json=as_json) as (context, output):
        description = "  ".join(describe(_get(context, token_id)))
        if dry_run:
            output.line(f"would get a new secret: {description}")
            return
        confirm(f"End the present secret in {grace:g} hours: {description}?", yes=yes)
        secret = token_hex(_SECRET_BYTES)
        # Every earlier secret works until its own time ends, and for `grace` at most.
        context.store.tokens.update(
            token_id,
            lambda known: with_secret(known, secret_hash(secret), context.now, int(grace * HOUR_S)),
        )
        _print_token(output, f"cdb_{token_id}_{secret}")
