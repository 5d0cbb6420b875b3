"""Every type of a problem is an address of the site that says what to do."""

import re
from pathlib import Path
from typing import get_args
from urllib.parse import urlsplit

from calibdb import errors
from calibdb.schema.board import BoardKind
from infra.web_build.docs.build import PROBLEMS
from infra.web_build.operation import texts

ROOT = Path(__file__).parents[4]
#: kinds of boards, which code names alike
BOARDS = get_args(BoardKind)


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
    assert f"{address.path.strip('/')}/index.html" == PROBLEMS
    assert address.fragment == "not-found"
    entries = dict(heading.split(": ") for heading in texts("problems.md"))
    wanted = kinds()
    assert set(entries) == set(wanted)
    assert {kind: int(entries[kind].split(",")[0]) for kind, status in wanted.items() if status} == {
        kind: status for kind, status in wanted.items() if status
    }
