"""Documentation pages: links that resolve, pages that are small, words about every call."""

import functools
import gzip
import json
import posixpath
import re
from urllib.parse import urlsplit

import pytest

from calibdb.access.plans import PLANS
from infra.web_build import site
from infra.web_build.docs import markdown
from infra.web_build.docs.build import NOT_SEARCHED, SEARCH_KEY
from infra.web_build.docs.catalog import ROOT, entries
from infra.web_build.openapi import OPERATIONS

MAX_PAGE_KB = 150
MARKDOWN = sorted(
    {
        *(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")),
        *("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"),
        *(entry.source for entry in entries() if entry.source),
    }
)


@functools.cache
def rendered(source: str) -> tuple[set[str], list[str]]:
    """Anchors of a document, and targets of its links."""
    targets: list[str] = []
    document = markdown.render((ROOT / source).read_text(), targets.append)
    return {each.anchor for each in document.sections}, targets


@pytest.mark.parametrize("source", MARKDOWN)
def test_every_link_of_a_document_leads_to_a_file_and_an_anchor(source: str) -> None:
    for target in rendered(source)[1]:
        parts = urlsplit(target)
        if parts.scheme:
            assert parts.scheme in {"https", "http", "mailto"}, target
            continue
        path = (
            posixpath.normpath(posixpath.join(posixpath.dirname(source), parts.path))
            if parts.path
            else source
        )
        assert (ROOT / path).exists(), f"{source}: {target}"
        if parts.fragment and path.endswith(".md"):
            assert parts.fragment in rendered(path)[0], f"{source}: {target}"


def test_every_document_of_the_folder_is_on_the_site() -> None:
    shown = {entry.source for entry in entries()}
    assert {path for path in MARKDOWN if path != "README.md"} <= shown


def test_documentation_pages_with_all_they_load_are_below_150_kb() -> None:
    """As the edge sends them, compressed: page, style, modules, and the fonts of the language."""
    made = site.made_files()
    sizes: dict[str, int] = {}
    style = (site.WEB / "style.css").read_text()
    named = re.findall(r'url\("\./([^"]+)"\)', style)
    fonts = sum((site.WEB / path).stat().st_size for path in named if "cyrillic" not in path)
    for key in [key for key in made if key.startswith("docs/") and key.endswith(".html")]:
        loaded = {"icon.svg", *re.findall(r' (?:href|src)="/([^"]+\.(?:css|js))"', made[key].decode())}
        contents = [made.get(name) or (site.WEB / name).read_bytes() for name in sorted(loaded)]
        sizes[key] = fonts + sum(len(gzip.compress(each)) for each in [made[key], *contents])
    largest = max(sizes, key=lambda key: sizes[key])
    assert sizes[largest] < 1000 * MAX_PAGE_KB, (largest, sizes[largest])
    assert len(sizes) > 20


def test_search_knows_every_document_call_and_problem() -> None:
    made = site.made_files()
    addresses = {address for address, *_ in json.loads(made[SEARCH_KEY])}
    folders = {address.partition("/")[0] for address in addresses}
    assert {entry.slug for entry in entries()} - NOT_SEARCHED <= folders
    assert {f"reference/{call.tag.lower()}/#{call.name}" for call in OPERATIONS} <= addresses
    assert "problems/#quota" in addresses
    assert len(gzip.compress(made[SEARCH_KEY])) < 120_000, "fetched when somebody begins to type"


def test_every_form_of_the_reference_sends_what_its_fields_say() -> None:
    made = site.made_files()
    pages = "".join(made[key].decode() for key in made if re.fullmatch("docs/reference/.+html", key))
    forms = dict(re.findall(r'<form data-operation="(\w+)"(.*?)</form>', pages, re.DOTALL))
    assert set(forms) == {operation.name for operation in OPERATIONS}
    for operation in OPERATIONS:
        form = forms[operation.name]
        assert f'data-path="{operation.path}"' in form
        fields = set(re.findall(r'name="path-(\w+)"', form))
        assert fields == set(re.findall(r"{(\w+)}", operation.path)), operation.name


def test_no_page_of_the_documentation_has_a_script_or_style_of_its_own() -> None:
    made = site.made_files()
    for key in [key for key in made if "docs/" in key and key.endswith(".html")]:
        page = made[key].decode()
        assert not re.search(
            r"<[^>]*\sstyle=|<style|<script(?![^>]*\s(?:src=|type=\"application/json\"))|\son[a-z]+=\"",
            re.sub(r"<pre.*?</pre>", "", page, flags=re.DOTALL),
        ), key


def test_limits_are_those_of_the_plans() -> None:
    text = (ROOT / "docs/limits.md").read_text()
    for name in ("trial", "free"):
        plan = PLANS[name]
        (row,) = re.findall(rf"^\| `{name}`.*$", text, re.MULTILINE)
        wanted = [
            f"{getattr(plan.together, kind):,} / {getattr(plan.each, kind):,}"
            for kind in ("sessions", "views", "poses", "lookups")
        ]
        assert [cell.strip() for cell in row.split("|")[2:-1]] == wanted
