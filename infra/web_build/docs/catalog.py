"""Documents that the site shows under `/docs/`, and where each lies."""

import itertools
import json
import posixpath
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

ROOT = Path(__file__).resolve().parents[3]
FOLDER = "docs/"
_CATALOG = ROOT / "web" / "templates" / "docs" / "documents.json"


@dataclass(frozen=True)
class Entry:
    """One document.

    `slug`: folder under `/docs/`. `uses_service`: the page fills the site's address and the visitor's token
    into its code. `path`: in the repository, None if the page is made otherwise.
    """

    slug: str
    name: str
    summary: str
    uses_service: bool = False
    path: str | None = "docs/{slug}.md"

    @property
    def source(self) -> str | None:
        """Path in the repository."""
        return self.path and self.path.format(slug=self.slug)

    @property
    def key(self) -> str:
        """Path of its page in the site."""
        return f"{FOLDER}{self.slug}/index.html"

    @property
    def address(self) -> str:
        """Address of its page, from the root."""
        return f"/{FOLDER}{self.slug}/"


def groups() -> dict[str, list[Entry]]:
    """Return the documents by group, in the order of the navigation.

    That omits the group `contributors`, to which the page *Contributing* links.
    """
    catalog = json.loads(_CATALOG.read_text(encoding="utf-8"))
    return {name: [Entry(**each) for each in documents] for name, documents in catalog.items()}


def entries() -> list[Entry]:
    """Return all documents."""
    return list(itertools.chain(*groups().values()))


def address(source: str, target: str) -> str | None:
    """Return the address on the site of a link's target in the document `source`, a path relative to that.

    None if the site does not have it.
    """
    parts = urlsplit(target)
    if parts.scheme or not parts.path:  # outside the repository, or an anchor of this document
        return target
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), parts.path))
    anchor = f"#{parts.fragment}" if parts.fragment else ""
    for entry in entries():
        if entry.source == path:
            return entry.address + anchor
    if path == "README.md":
        return f"/{FOLDER}"
    if path.startswith("docs/images/"):
        return f"/{path}"
    if path.startswith("web/") and (ROOT / path).exists():
        folder_mark = "/" if (ROOT / path).is_dir() else ""
        return f"{path.removeprefix('web').removesuffix('index.html')}{folder_mark}{anchor}"
    return None
