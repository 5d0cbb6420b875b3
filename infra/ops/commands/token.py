"""Commands about API tokens."""

from __future__ import annotations

from typing import Annotated

import typer

from infra.console import confirm
from infra.ops.options import DryRun, Json, Yes, complete_plan
from infra.ops.session import open_run

app = typer.Typer(help="Issue, list, rotate and revoke API tokens.", no_args_is_help=True)
TokenId = Annotated[str, typer.Argument(metavar="ID", help="As `token list` prints it.")]


@app.command("create")
def create_token(
    origin: Annotated[
        list[str] | None, typer.Option(help="Origin that may use the token; repeatable. None: any.")
    ] = None,
    plan: Annotated[
        str, typer.Option(help="Plan, which limits its use in an hour.", autocompletion=complete_plan)
    ] = "free",
    as_json: Json = False,
) -> None:
    """Issue a token; it is shown once."""
    with open_run(as_json=as_json) as run:
        from infra.ops import tokens

        token = tokens.create(run.context, origin or [], plan)
        run.output.line(token)
        run.output.value({"token": token})


@app.command("list")
def list_tokens(as_json: Json = False) -> None:
    """List all tokens, without their secrets."""
    with open_run(as_json=as_json) as run:
        from infra.ops import tokens

        listing = tokens.list_all(run.context)
        rows = [tokens.describe(token) for token in listing]
        run.output.table(
            ("id", "created", "plan", "made by", "origins"), rows, ("  ".join(row) for row in rows)
        )
        run.output.value(
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
    with open_run(as_json=as_json) as run:
        from infra.ops import tokens

        token = tokens.get(run.context, token_id)
        use = tokens.use(run.context, token_id)
        run.output.line("  ".join(tokens.describe(token)))
        periods = [
            *((used.hour, used) for used in use.hours),
            *((used.day, used) for used in use.days),
        ]
        rows = [
            (period, *map(str, (used.sessions, used.views, used.poses, used.lookups)))
            for period, used in periods
            if used.sessions or used.views or used.poses or used.lookups
        ]
        run.output.table(
            ("period (UTC)", "sessions", "views", "poses", "lookups"), rows, ("  ".join(row) for row in rows)
        )
        run.output.value({"id": token.id, "plan": token.plan, "use": use.model_dump(mode="json")})


@app.command("made")
def count_made(as_json: Json = False) -> None:
    """Count the tokens that people made for themselves, day by day."""
    with open_run(as_json=as_json) as run:
        days = list(run.context.store.quotas.issued())
        rows = [(day, str(count)) for day, count in days]
        run.output.table(("day (UTC)", "tokens"), rows, ("  ".join(row) for row in rows))
        run.output.value([{"day": day, "tokens": count} for day, count in days])


@app.command("sweep")
def sweep_tokens(dry_run: DryRun = False) -> None:
    """Remove trial tokens that expired unused, a week after their end."""
    with open_run() as run:
        store = run.context.store.tokens
        orphans = store.orphans(run.context.now)
        count = len(orphans) if dry_run else store.remove(orphans)
        run.output.line(f"{count} trial tokens {'would be ' if dry_run else ''}removed")


@app.command("revoke")
def revoke_token(token_id: TokenId, dry_run: DryRun = False, yes: Yes = False) -> None:
    """Revoke a token for good, within a minute."""
    with open_run() as run:
        from infra.ops import tokens

        token = tokens.get(run.context, token_id)
        description = "  ".join(tokens.describe(token))
        if dry_run:
            run.output.line(f"would be revoked: {description}")
            return
        confirm(f"Revoke for good: {description}?", yes=yes)
        tokens.revoke(run.context, token_id)


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
    with open_run(as_json=as_json) as run:
        from infra.ops import tokens

        token = tokens.get(run.context, token_id)
        description = "  ".join(tokens.describe(token))
        if dry_run:
            run.output.line(f"would get a new secret: {description}")
            return
        confirm(f"End the present secret in {grace:g} hours: {description}?", yes=yes)
        fresh = tokens.rotate(run.context, token_id, grace)
        run.output.line(fresh)
        run.output.value({"token": fresh})
