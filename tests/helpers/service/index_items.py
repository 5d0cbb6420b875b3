"""The index of a server, or of an emulated stack, as its table has it."""

from typing import Any

from calibdb.settings import Settings
from calibdb.store.ports import Item
from calibdb.store.storage import storage_of

Key = tuple[str, str]  # pk, sk


def items(stack: Any) -> dict[Key, Item]:
    """All items of the table but for times, leases, counters and aliases, once no job may change any."""
    stack.wait_until_idle(60)
    table = storage_of(Settings.from_environment(stack.environment)).table
    found = {}
    for pk, sk in table.keys(""):
        item = table.get(pk, sk)
        if item is None or sk.startswith(("QUOTA#", "SHARE#")) or pk.startswith(("REFIT#", "ALIAS")):
            continue
        found[pk, sk] = {k: v for k, v in item.items() if k != "ttl"}
    return found


def remove(stack: Any, *keys: Key) -> None:
    table = storage_of(Settings.from_environment(stack.environment)).table
    for key in keys:
        table.delete(*key)
