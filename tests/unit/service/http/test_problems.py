"""Every type of a problem is an address of the site that says what to do."""

import re
from pathlib import Path
from typing import get_args
from urllib.parse import urlsplit

from calibdb import errors
from calibdb.schema.board import BoardKind

ROOT = Path(__file__).parents[4]
#: kinds of boards, which code names alike
BOARDS = get_args(BoardKind)
PAGE = ROOT / "web" / "docs" / "problems" / "index.html"


def kinds() -> dict[str, int | None]:
    """Kinds that the code answers with, and the status where the class alone tells it."""
    found: dict[str, int | None] = {"internal": 500, "method-not-allowed": 405}
    for member in vars(errors).values():
        if isinstance(member, type) and issubclass(member, errors.CalibdbError):
            found[member.kind] = member.status
    for folder in ("functions", "layers/service/calibdb"):
        for path in (ROOT / folder).rglob("*.py"):
            for kind in re.findall(r'\bkind="([a-z-]+)"', path.read_text()):
                if kind not in BOARDS:
                    found.setdefault(kind, None)
    return found


def test_every_kind_has_an_entry_on_the_page() -> None:
    address = urlsplit(errors.NotFoundError("").problem()["type"])
    assert ROOT / "web" / address.path.strip("/") == PAGE.parent
    assert address.fragment == "not-found"
    entries = dict(re.findall(r'<dt id="([a-z-]+)"><code>\1</code> <span>(\d+), ', PAGE.read_text()))
    wanted = kinds()
    assert set(entries) == set(wanted)
    assert {kind: int(entries[kind]) for kind, status in wanted.items() if status} == {
        kind: status for kind, status in wanted.items() if status
    }
