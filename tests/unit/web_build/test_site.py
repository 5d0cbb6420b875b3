"""The site that is made of page sources: one frame, every language, addresses that hold in every folder."""

import functools
import json
import posixpath
import re
import shutil
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from infra.web_build import site

ROOT = Path(__file__).parents[3]
PAGE = """<!doctype html>
<html lang="en">
<head>
  <title>Trial</title>
  <link rel="stylesheet" href="./main.css">
  <script type="module" src="./main.js"></script>
</head>
<body>
  <div class="page">
    <header class="masthead">old</header>
    <main>
      <h1 data-t="common.board">Board</h1><a href="../board/?squares=8x5">b</a><a href="../docs/">d</a>
    </main>
  </div>
</body>
</html>
"""


@functools.cache
def pages() -> dict[str, str]:
    return {key: content.decode() for key, content in site.made_files().items() if key.endswith(".html")}


def test_every_page_is_there_in_every_language_with_its_texts() -> None:
    found = pages()
    for folder, language, words in (("", "en", "Cameras"), ("de/", "de", "Kameras"), ("uk/", "uk", "Камери")):
        page = found[f"{folder}cameras/index.html"]
        assert f'<html lang="{language}">' in page
        assert re.search(rf"<h1[^>]*>{words}</h1>", page)
    # A text that no catalog has would stand there as its key.
    for key, page in found.items():
        assert not re.search(r'data-t="([\w.]+)"[^>]*>\1<', page), key


def test_one_head_header_and_footer_on_all_pages() -> None:
    for key, page in pages().items():
        for once in (
            '<meta charset="utf-8">',
            'name="viewport"',
            'rel="icon"',
            'rel="manifest"',
            'href="/style.css"',
        ):
            assert page.count(once) == 1, (key, once)
        assert page.count('class="skip"') == 1, key
        assert page.count('class="page"') == page.count('<footer class="foot">'), key
        navigations = page.count('<header class="masthead">') + page.count(' class="site"')
        assert navigations == page.count('<details class="menu">'), key


def test_pages_share_the_fields_of_boards_and_the_consent() -> None:
    found = pages()
    for key, page in found.items():
        assert "<div data-part" not in page, key
        ids = re.findall(r' id="([^"]+)"', page)
        assert len(ids) == len(set(ids)), key
    for part, sharing in (("board-kind", 3), ("consent", 4)):
        assert sum(f'id="{part}"' in page for page in found.values()) == 3 * sharing  # in three languages


def test_every_address_on_every_page_leads_to_a_file_and_an_anchor() -> None:
    made = site.made_files()
    files = {path.relative_to(site.WEB).as_posix() for path in site.WEB.rglob("*") if path.is_file()}
    every = pages()
    ids = {key: set(re.findall(r'\bid="([^"]+)"', page)) for key, page in every.items()}
    checked = 0
    for key, page in every.items():
        for address in re.findall(r'(?:href|src)="([^"]*)"', page):
            parts = urlsplit(address)
            if parts.scheme or parts.path.startswith("/dumps/"):  # objects that the weekly dump writes
                continue
            there = posixpath.normpath(posixpath.join("/", posixpath.dirname(key), parts.path))[1:]
            there = there if parts.path else key
            if parts.path.endswith("/") or not there:
                there = posixpath.join(there, "index.html")
            assert there in files | made.keys(), (key, address, there)
            if parts.fragment and there in ids:
                assert unquote(parts.fragment) in ids[there], (key, address)
            checked += 1
    assert checked > 3000


def test_a_page_contains_the_messages_that_it_may_show_in_its_language() -> None:
    every = pages()

    def texts(key: str) -> dict[str, object]:
        (found,) = re.findall(r'<script type="application/json" id="messages">(.*?)</script>', every[key])
        parsed: dict[str, object] = json.loads(found)
        return parsed

    german = texts("de/board/index.html")
    assert german["board.full_screen"] == "Im Vollbild zeigen"
    assert german.keys() == texts("board/index.html").keys() == texts("uk/board/index.html").keys()
    assert not [key for key in german if key.startswith(("capture.", "rig.", "result."))]
    # Shown by modules that are loaded at the end of a capture.
    assert {"result.tab_numbers", "formats.writing"} <= texts("calibrate/index.html").keys()
    for key, page in every.items():
        marked = set(re.findall(r'data-t(?:-label|-title|-alt|-content)?="([\w.]+)"', page))
        if 'id="messages"' in page:
            assert marked <= texts(key).keys(), key
        assert not re.search(r' data-t="[^"]+"[^>]*></', page), f"{key}: a text is not in its place"


def test_pages_can_be_installed() -> None:
    made = site.made_files()
    manifest = json.loads((site.WEB / "manifest.json").read_text())
    assert all((site.WEB / icon["src"]).is_file() for icon in manifest["icons"])
    for address in (manifest["start_url"], *(shortcut["url"] for shortcut in manifest["shortcuts"])):
        assert f"{address[1:]}index.html" in made


def test_pages_preload_the_modules_that_they_import() -> None:
    def preloaded(key: str) -> set[str]:
        return set(re.findall(r'rel="modulepreload" href="/([^"]+)"', pages()[key]))

    # The page's module, its imports, theirs, and those of others
    modules = {"board/main.js", "board/screen.js", "lib/board-drawing.js", "vendor/dictionaries.js"}
    assert modules <= preloaded("board/index.html")
    assert "lib/result/view.js" not in preloaded("calibrate/index.html"), "loaded at the end of a capture"


def test_scripts_of_the_site_keep_their_names_and_lose_their_comments() -> None:
    made = site.made_files()
    assert b"export function addMessages(" in made["lib/i18n.js"]
    assert b"/**" not in made["lib/i18n.js"]
    assert len(made["sdk/projection.js"]) < 0.6 * (site.WEB / "sdk/projection.js").stat().st_size
    assert "examples/picture.js" not in made, "read by people"


def test_a_changed_source_is_another_site_and_absent_pages_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    web = tmp_path / "web"
    messages = [f"messages/{language}/common.json" for language in ("en", *site.LANGUAGES)]
    for name in ("lib/i18n.js", "lib/header.js", "lib/code-block.js", *messages):
        (web / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(site.WEB / name, web / name)
    for name in ("trial", "board"):
        (web / name).mkdir()
        (web / name / "index.html").write_text(PAGE)
    (web / "docs").mkdir()
    (web / "docs/index.html").write_text(PAGE.replace(' data-t="common.board"', ""))
    options = site.Options("https://site.example", {"contact": "mailto:a@site.example"})
    made = site.made_files(web, options)
    page = made["de/trial/index.html"].decode()
    assert ".invalid" not in page, "imprint, which is not given"
    assert '<link rel="alternate" hreflang="en" href="https://site.example/trial/">' in page
    assert '<link rel="canonical" href="https://site.example/de/trial/">' in page
    assert '<script src="/language.js"></script>' in page
    assert 'href="mailto:a@site.example"' in page
    for address in ("../board/?squares=8x5", "../board/"):  # its own, and that of the navigation
        assert f'<a href="{address}"' in page, "in the same language"
    assert '<a href="/docs/">' in page, "which is there in English only"
    assert "old" not in page
    assert "cameras/" not in page
    assert "de/docs/index.html" not in made
    (web / "trial/index.html").write_text(PAGE.replace("Trial", "Another"))
    monkeypatch.setattr(site, "_build", lambda _: {"built": "again"})
    assert "built" in site.made_files(web, options)


def test_a_folder_without_catalogs_is_served_as_it_lies(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("x")
    assert site.made_files(tmp_path) == {}
