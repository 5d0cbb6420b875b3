"""Running sessions under optimistic concurrency (`Versions`): `sessions/<sid>/<version>.json`.

Their views are up to a megabyte, so that another target, or the number of duplicates, is stored in the index
item.
"""

from __future__ import annotations

from calibdb.schema import SessionDocument
from calibdb.store.versions import Versions


class Sessions(Versions[SessionDocument]):
    """Sessions under their names."""

    model = SessionDocument
    prefix = "sessions/"
    partition = "SESSION#"
    noun = "session"
    missing = "No session was started under this session id."
    missing_kind = "no-session"
    small = ("target", "skipped", "duplicates")
