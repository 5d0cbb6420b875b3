"""All pages under `/docs/` and `/examples/`, and the texts that the search reads."""

import itertools
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from html import unescape
from pathlib import Path

from infra.web_build import openapi
from infra.web_build.docs import catalog, markdown
from infra.web_build.docs.catalog import FOLDER, ROOT, Entry
from infra.web_build.docs.fields import body_rows
from infra.web_build.docs.markdown import Document, Section
from infra.web_build.docs.templates import SITE, render
from infra.web_build.openapi import OPERATIONS
from infra.web_build.operation import TAGS, texts
from infra.web_build.sdk import import_map

PROBLEMS = f"{FOLDER}problems/index.html"
SEARCH_KEY = f"{FOLDER}search.json"
NOT_SEARCHED = frozenset({"changelog", "decisions", "development"})
"""Documents for contributors, and one that repeats, by version, what the others explain."""
_CALLS = {tag: [operation for operation in OPERATIONS if operation.tag == tag] for tag in TAGS}
_EXAMPLES = ("three", "babylon", "aframe", "arjs", "stereo")
_MAX_DESCRIPTION = 160  # characters
_IMPORT_MAP = re.compile(r'(```html sdk-import-map\n<script type="importmap">\n).*?(\n</script>)', re.DOTALL)


def pages(web: Path) -> Mapping[str, str]:
    """Make the pages of documentation and examples, and the texts that they load, by key.

    A folder without `docs/docs.js` is not our client.
    """
    if not (web / FOLDER / "docs.js").is_file():
        return {}
    documents = list(_documents())
    images = sorted((ROOT / "docs" / "images").glob("*.svg"))
    return {
        **{entry.key: _page(entry, document) for entry, document in documents},
        **dict(_reference()),
        f"{FOLDER}index.html": render("docs/home.html"),
        PROBLEMS: render("docs/problems.html", PROBLEMS, problems=list(_problems())),
        **{f"examples/{name}/index.html": _example(web, name) for name in _EXAMPLES},
        SEARCH_KEY: search_texts(documents),
        **{path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in images},
    }


def _documents() -> Iterator[tuple[Entry, Document]]:
    for entry in catalog.entries():
        if entry.source:
            text = (ROOT / entry.source).read_text(encoding="utf-8")
            text = _IMPORT_MAP.sub(lambda match: match[1] + import_map(ROOT / "web", SITE) + match[2], text)
            yield entry, markdown.render(text, partial(catalog.address, entry.source))


def _page(entry: Entry, document: Document) -> str:
    first = next((section.text[0] for section in document.sections if section.text), entry.summary)
    about = re.sub(r"\s+", " ", first)
    if len(about) > _MAX_DESCRIPTION:
        about = about[:_MAX_DESCRIPTION].rsplit(" ", 1)[0] + " …"
    return render(
        "docs/page.html",
        entry.key,
        document.sections,
        title=document.title,
        description=about,
        body=document.html,
        uses_service=entry.uses_service,
    )


def _reference() -> Iterator[tuple[str, str]]:
    """Yield the key and the page of all calls, and of each group of them."""
    key = f"{FOLDER}reference/index.html"
    yield key, render("docs/reference.html", key, tags=TAGS, operations=_CALLS)
    for tag, operations in _CALLS.items():
        key = f"{FOLDER}reference/{tag.lower()}/index.html"
        sections = [Section(2, operation.signature, operation.name) for operation in operations]
        calls = [(operation, openapi.node(operation)) for operation in operations]
        values = {"tag": tag, "description": TAGS[tag], "calls": calls, "uses_service": True}
        yield key, render("docs/calls.html", key, sections, **values)


def _example(web: Path, name: str) -> str:
    def source(script: str) -> str:
        return (web / "examples" / script).read_text(encoding="utf-8")

    return render(f"examples/{name}.html", folder=name, source=source)


def _problems() -> Iterator[tuple[str, str, str]]:
    """Yield kind, status with title, and explanation of each problem, which is HTML."""
    for heading, paragraph in texts("problems.md").items():
        kind, _, status = heading.partition(": ")
        yield kind, status, markdown.inline(paragraph, lambda target: target)


def search_texts(documents: Sequence[tuple[Entry, Document]]) -> str:
    """Return the sections of all documents as JSON: `[[address, page, title, text], …]`."""
    found = []
    for entry, document in documents:
        if entry.slug not in NOT_SEARCHED:
            found += [_row(entry.slug, document.title, section) for section in document.sections]
    for operation in itertools.chain(*_CALLS.values()):
        fields = [f"{row.name} {row.text}" for row in body_rows(openapi.node(operation))]
        title = f"{operation.signature}: {operation.summary}"
        section = Section(2, title, operation.name, [operation.description, *fields])
        found.append(_row(f"reference/{operation.tag.lower()}", "API reference", section))
    for kind, status, text in _problems():
        section = Section(2, f"{kind} ({status})", kind, [unescape(re.sub("<[^>]+>", "", text))])
        found.append(_row("problems", "Problems", section))
    return json.dumps(found, ensure_ascii=False, separators=(",", ":"))


def _row(folder: str, name: str, section: Section) -> list[str]:
    anchor = f"#{section.anchor}" if section.anchor else ""
    # Cells of digits and names of tests are not searched.
    said = " ".join(part for part in section.text if re.search("[A-Za-z]", part))
    text = re.sub(r"\s+", " ", re.sub(r"tests/\S+", "", said)).strip()
    return [f"{folder}/{anchor}", name, section.title, text]
