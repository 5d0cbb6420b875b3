"""A table as it is after years: other cameras, by the tens of thousands."""

from calibdb.store.ports import IF_NOT_EXISTS, Item
from infra.server.server import Server
from tests.helpers.service.known import consensus


def crowd(stack: Server, count: int) -> None:
    """Put cameras into the table, each with a consensus and a name."""
    document = consensus(camera="Another").model_dump_json()
    for first in range(0, count, 5_000):
        items: list[Item] = []
        for n in range(first, min(first + 5_000, count)):
            key = f"c4-another-{n:012x}"
            sk = "CONSENSUS#1280x720#0#rectilinear"
            items.append({"pk": f"CAMERA#{key}", "sk": sk, "basis": "", "document": document})
            items.append({"pk": "CAMERAS#", "sk": key, "name": "another"})
        assert stack.storage.table.put_transaction(items, IF_NOT_EXISTS)
