"""Last run of the canary: `HEALTH#CANARY/LAST`. It expires; nothing depends on it."""

from calibdb.schema.health import CanaryRun
from calibdb.store.ports import Table

_PK, _SK = "HEALTH#CANARY", "LAST"
EXPIRY_S = 2 * 3600


def store_canary_run(table: Table, run: CanaryRun) -> None:
    """Store a run, over the one before."""
    table.put({"pk": _PK, "sk": _SK, "run": run.model_dump_json(), "ttl": run.at + EXPIRY_S})


def last_canary_run(table: Table, now: int) -> CanaryRun | None:
    """Last run; None if there was none lately."""
    item = table.get(_PK, _SK)
    run = None if item is None else CanaryRun.model_validate_json(item["run"])
    return run if run is not None and now < run.at + EXPIRY_S else None
