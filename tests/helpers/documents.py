"""Documents of `/docs/` and the blocks of code in them."""

import re
from dataclasses import dataclass
from textwrap import dedent

from infra.web_build.docs.catalog import entries
from tests.helpers.data import ROOT

_FENCE = re.compile(r"^( *)```(\S+)([^\n]*)\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
SITE = "http://127.0.0.1:8000"
#: languages of code; other blocks are answers, formats and addresses
CODE = ("sh", "js", "html", "python")


@dataclass(frozen=True)
class Block:
    source: str
    line: int
    language: str
    mark: str
    code: str

    @property
    def reason(self) -> str | None:
        """Reason why it is not run; None if it is."""
        return self.mark.removeprefix("not-run:").strip() if self.mark.startswith("not-run") else None


def sources() -> list[str]:
    """Paths of the site's documents and of the README."""
    return [*(entry.source for entry in entries() if entry.source), "README.md"]


def blocks(source: str) -> list[Block]:
    text = (ROOT / source).read_text()
    return [
        Block(source, text[: match.start()].count("\n") + 1, match[2], match[3].strip(), dedent(match[4]))
        for match in _FENCE.finditer(text)
    ]
