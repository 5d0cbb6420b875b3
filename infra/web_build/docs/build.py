"""All pages under `/docs/`, and the texts that their search reads."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape, unescape
from pathlib import Path
from urllib.parse import urlsplit

from infra.web_build.docs import catalog, reference
from infra.web_build.docs.catalog import ENTRIES, FOLDER, GROUPS, ROOT, Entry, address
from infra.web_build.docs.markdown import Document, Link, Section, render
from infra.web_build.docs.page import GROUP_NAMES, page
from infra.web_build.docs.samples import SITE, fill
from infra.web_build.sdk import import_map

OVERVIEW = f"{FOLDER}index.html"
SEARCH_KEY = f"{FOLDER}search.json"
NOT_SEARCHED = frozenset({"changelog", "decisions", "development"})
"""Documents for contributors, and one that repeats, by version, what the others explain."""
_LEAD = (
    "calibDB gives your program the camera matrix, the lens distortion and their uncertainty. Begin with one "
    "of these, or search."
)
_FIRST = ("quickstart", "sdk", "reference")  # documents to begin with
_MAX_DESCRIPTION = 160  # characters
_IMPORT_MAP = re.compile(r'(```html sdk-import-map\n<script type="importmap">\n).*?(\n</script>)', re.DOTALL)
_PROBLEM = re.compile(
    r'<dt id="([a-z-]+)"><code>\1</code> <span>(.*?)</span></dt>\s*<dd>(.*?)</dd>', re.DOTALL
)


def pages(web: Path) -> Mapping[str, str]:
    """Make the pages of the documentation, and the texts that they load, by key.

    A folder without `docs/docs.js` is not our client.
    """
    if not (web / FOLDER / "docs.js").is_file():
        return {}
    rendered = list(_documents())
    made = {entry.key: _page(entry, document) for entry, document in rendered}
    loaded = {SEARCH_KEY: search_texts(web, rendered)} | {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted((ROOT / "docs" / "images").glob("*.svg"))
    }
    return made | dict(reference.pages()) | {OVERVIEW: _home()} | loaded


def _documents() -> Iterator[tuple[Entry, Document]]:
    for entry in ENTRIES:
        if entry.source:
            text = (ROOT / entry.source).read_text(encoding="utf-8")
            text = _IMPORT_MAP.sub(lambda match: match[1] + import_map(ROOT / "web", SITE) + match[2], text)
            yield entry, render(text, _link_from(entry))


def _link_from(entry: Entry) -> Link:
    def link(target: str) -> str | None:
        if urlsplit(target).scheme:  # outside the repository
            return target
        page_key = catalog.target_key(entry.source or "", target)
        if page_key is None:
            return None
        key, anchor = page_key
        there = "" if key == entry.key and anchor else address(entry.key, key)
        return there + (f"#{anchor}" if anchor else "")

    return link


def search_texts(web: Path, rendered: Sequence[tuple[Entry, Document]]) -> str:
    """Return the sections of all documents as JSON: `[[address, page, title, text], …]`."""
    rows = []
    for entry, document in rendered:
        if entry.slug in NOT_SEARCHED:
            continue
        rows += [_row(entry.slug, document.title, section) for section in document.sections]
    for folder, section in reference.sections():
        rows += [_row(f"reference/{folder}", "API reference", section)]
    problems = (web / FOLDER / "problems" / "index.html").read_text(encoding="utf-8")
    for kind, status, text in _PROBLEM.findall(problems):
        plain = unescape(re.sub("<[^>]+>", "", text))
        rows += [_row("problems", "Problems", Section(f"{kind} ({unescape(status)})", kind, [plain]))]
    return json.dumps(rows, ensure_ascii=False, separators=(",", ":"))


def _row(folder: str, name: str, section: Section) -> list[str]:
    anchor = f"#{section.anchor}" if section.anchor else ""
    # Cells of digits and names of tests are not searched.
    said = " ".join(part for part in section.text if re.search("[A-Za-z]", part))
    text = re.sub(r"\s+", " ", re.sub(r"tests/\S+", "", said)).strip()
    return [f"{folder}/{anchor}", name, section.title, text]


def _page(entry: Entry, document: Document) -> str:
    body = fill(document.html) if entry.uses_service else document.html
    first = next((section.text[0] for section in document.sections if section.text), entry.summary)
    about = re.sub(r"\s+", " ", first)
    if len(about) > _MAX_DESCRIPTION:
        about = about[:_MAX_DESCRIPTION].rsplit(" ", 1)[0] + " …"
    return page(entry.key, document.title, about, body, document.headings, uses_service=entry.uses_service)


def _cards(entries: Sequence[Entry]) -> str:
    return "".join(
        f'<li><a href="{address(OVERVIEW, entry.key)}">{escape(entry.name)}</a>'
        f"<span>{escape(entry.summary)}</span></li>"
        for entry in entries
    )


def _home() -> str:
    first = [entry for entry in GROUPS["start"] if entry.slug in _FIRST]
    parts = [f'<p class="lead">{_LEAD}</p>\n<ul class="cards first">{_cards(first)}</ul>']
    for name, entries in GROUPS.items():
        others = [entry for entry in entries if entry not in first]
        parts.append(f'<h2 id="{name}">{GROUP_NAMES[name]}</h2>\n<ul class="cards">{_cards(others)}</ul>')
    about = "Quickstart, API reference, SDK, Python client, formats, limits."
    return page(OVERVIEW, "Documentation", about, "\n".join(parts))
