"""Tokens of the site's own pages and of its canary: they follow the site's address."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from calibdb.access.tokens import parse
from calibdb.store import Tokens
from calibdb.store.storage import storage_named
from infra.deploy.aws import Account
from infra.ops.tokens import issue


def current_token(made: Mapping[str, str], region: str, settings: Mapping[str, str]) -> str:
    """Return the token for the pages, valid on every address of the site.

    `made`: outputs of the stack. `settings`: the deployed `/config.json`, empty if there is none.
    """
    return admit(_tokens(made, region), settings.get("token", ""), _origins(made))


def give_canary(made: Mapping[str, str], account: Account) -> None:
    """Give the canary a token, in a secure parameter that only it reads. `made`: outputs of the stack."""
    name, ssm = f"/calibdb/{account.stack}/CANARY_TOKEN", account.client("ssm")
    parameters = ssm.get_parameters(Names=[name], WithDecryption=True)["Parameters"]
    current = parameters[0]["Value"] if parameters else ""
    token = admit(_tokens(made, account.region), current, _origins(made), "free")
    if token != current:
        ssm.put_parameter(Name=name, Value=token, Type="SecureString", Overwrite=True)


def _tokens(made: Mapping[str, str], region: str) -> Tokens:
    storage = storage_named(region, made["TableName"], made["KeypointBucketName"])
    return Tokens(storage.table, storage.objects)


def _origins(made: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys([made["SiteUrl"], f"https://{made['DistributionDomain']}"]))


def admit(tokens: Tokens, known: str, origins: Sequence[str], plan: str = "page") -> str:
    """Return a token that admits pages of `origins`: the known one, changed if necessary, or a new one."""
    parts = parse(known)
    token = tokens.get(parts[0]) if parts else None
    if token is not None:
        if missing := [origin for origin in origins if origin not in token.origins]:
            tokens.change(replace(token, origins=(*token.origins, *missing)))
        return known
    return issue(tokens, origins, plan, int(time.time()))
