"""Running sessions under optimistic concurrency (`Versions`): `sessions/<sid>/<version>.json`."""

from __future__ import annotations

from calibdb.schema import SessionDocument
from calibdb.store.objects import Objects
from calibdb.store.table import Table
from calibdb.store.versions import Kind, Versions

_SESSIONS = Kind(
    SessionDocument,
    prefix="sessions/",
    partition="SESSION#",
    noun="session",
    missing="No session was started under this session id.",
    missing_kind="no-session",
)


class Sessions(Versions[SessionDocument]):
    """Sessions under their names."""

    def __init__(self, table: Table, objects: Objects) -> None:
        super().__init__(table, objects, _SESSIONS)
