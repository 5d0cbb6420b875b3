"""A table as it is after years: other cameras, by the tens of thousands."""

import json

from calibdb.settings import Settings
from infra.local import LocalStack
from infra.local.journal import ITEM, Address, Change, Content
from tests.helpers.service.known import consensus


def crowd(stack: LocalStack, count: int) -> None:
    """Put cameras into the table, each with a consensus and a name: by the way of the journal at a start."""
    table = Settings.from_environment(stack.environment).table_name
    document = consensus(camera="Another").model_dump_json()

    def item(pk: str, sk: str, **attributes: str) -> Change:
        content = {"pk": {"S": pk}, "sk": {"S": sk}, **{k: {"S": v} for k, v in attributes.items()}}
        return Change(Address(ITEM, table, json.dumps([pk, sk])), Content(json.dumps(content).encode()))

    for first in range(0, count, 5_000):
        changes = []
        for n in range(first, min(first + 5_000, count)):
            key = f"c4-another-{n:012x}"
            changes += [
                item(f"CAMERA#{key}", "CONSENSUS#1280x720#0#rectilinear", basis="", document=document),
                item("CAMERAS#", key, name="another"),
            ]
        stack.storage.persist(*changes)
