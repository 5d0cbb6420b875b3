"""Parts of a document that a command writes."""

import os
from pathlib import Path

from tests.helpers.data import ROOT

ACCURACY = ROOT / "docs" / "accuracy.md"


def replace(part: str, text: str, path: Path = ACCURACY) -> None:
    """Print `text`, and write it between `<!-- part: begin -->` and `<!-- part: end -->` of a document."""
    print(text)
    begin, end = f"<!-- {part}: begin -->", f"<!-- {part}: end -->"
    document = path.read_text()
    head, _, rest = document.partition(begin)
    _, found, tail = rest.partition(end)
    if not found:
        raise ValueError(f"{path} has no part {part!r}")
    path.write_text(f"{head}{begin}\n{text.strip()}\n{end}{tail}")


def is_chosen(name: str) -> bool:
    """True if the environment variable ONLY, names with commas between them, has a name, or is not set."""
    only = os.environ.get("ONLY", "")
    return not only or name in only.split(",")


def table(header: list[str], rows: list[list[str]]) -> str:
    lines = [header, ["-"] * len(header), *rows]
    return "\n".join(f"|{'|'.join(line)}|" for line in lines)
