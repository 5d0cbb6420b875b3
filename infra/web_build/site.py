"""The static site as served and deployed: files made of their sources, the rest as it lies in `web/`.

A page is an HTML file of `web/`, of the documentation or of the examples. `site.mjs` fills in the texts of
the message catalogs, and makes such pages in every language: `board/index.html` is also
`de/board/index.html`. It gives all pages the same header, footer, skip link and preloads, and fills in the
parts that several pages share (`web/templates/parts/`). Scripts and styles lose their comments and
indentation.

    python -m infra.web_build.site .build/web     # the whole site, as files

The server rebuilds them when one of their sources changed.
"""

import hashlib
import html
import json
import os
import re
import shutil
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from infra.web_build.docs.catalog import entries
from infra.web_build.sdk import SiteError, run_node, sdk_files, write_whole

ROOT = Path(__file__).parents[2]
WEB = ROOT / "web"
LANGUAGES = ("de", "uk")  # besides English; `web/lib/i18n.js` has them too
SOURCE_FOLDERS = ("messages", "templates")
"""Folders of `web/` that pages are made of. They are not served."""
MADE_FILES = ROOT / "built"
"""In a wheel, which has no sources: the files that are made."""
_CACHE = ROOT / ".build" / "site"
_MAX_CACHED = 16
# In the place of what a deployment says (`Options`), as the contacts in `web/templates/parts/foot.html`
_ANY_ORIGIN = "https://origin.invalid"
_PAGE_BUILDER = Path(__file__).parent / "site.mjs"
_MODELS = ROOT / "layers" / "service" / "calibdb" / "schema"
_INPUTS = (".html", ".js", ".css", ".mjs", ".py", ".md", ".json", ".toml", ".txt")


@dataclass(frozen=True)
class Options:
    """Facts about a deployment that its pages contain.

    `origin`: "https://calibdb.example"; without it, addresses for search engines are from the root.
    `contacts`: addresses under "contact" and "imprint" for the footer.
    """

    origin: str = ""
    contacts: Mapping[str, str] = field(default_factory=dict)


def made_files(web: Path = WEB, options: Options | None = None) -> Mapping[str, bytes]:
    """Make all files that are made, or take those made of the same sources before: key → content.

    Nothing is made of a folder without message catalogs. Raises SiteError.
    """
    options = options or Options()
    if not (MADE_FILES.is_dir() or (web / "messages").is_dir()):
        return {}
    state = "" if MADE_FILES.is_dir() else _state(web)
    return _completed(web, state, json.dumps(dict(options.contacts), sort_keys=True), options.origin)


def build_for_wheel(folder: Path) -> None:
    """Write to a folder, a wheel's `MADE_FILES`, the files that are made."""
    _write(folder, _make_files(WEB, _state(WEB)))


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    for key, content in files.items():
        (folder / key).parent.mkdir(parents=True, exist_ok=True)
        (folder / key).write_bytes(content)


@lru_cache(maxsize=8)
def _completed(web: Path, state: str, contacts_text: str, origin: str) -> Mapping[str, bytes]:
    """Put the site's own address and contacts in: one build serves all, on any port."""
    contacts = json.loads(contacts_text)
    if state:
        files = dict(_make_files(web, state))
    else:
        paths = (path for path in MADE_FILES.rglob("*") if path.is_file())
        files = {path.relative_to(MADE_FILES).as_posix(): path.read_bytes() for path in paths}
    for key in [key for key in files if key.endswith(".html")]:
        text = files[key].decode().replace(_ANY_ORIGIN, origin)
        for name in ("contact", "imprint"):
            place = f"https://{name}.invalid"
            if contacts.get(name):
                text = text.replace(place, html.escape(contacts[name]))
            else:
                text = re.sub(rf'<li><a href="{re.escape(place)}"[^>]*>[^<]*</a></li>', "", text)
        files[key] = text.encode()
    return files


def _sources(web: Path, generated: Mapping[str, str]) -> dict[str, str]:
    written = {
        path.relative_to(web).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(web.rglob("*.html"))
    }
    pages = {key: text for key, text in generated.items() if key.endswith(".html")} | written
    return {key: text for key, text in pages.items() if not key.startswith(("vendor/", "templates/"))}


@lru_cache(maxsize=8)
def _make_files(web: Path, state: str) -> Mapping[str, bytes]:
    """Make the files once for all processes: it takes seconds."""
    cache_file = _CACHE / f"{state[:24]}.json"
    try:
        texts: dict[str, str] = json.loads(cache_file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        texts = _build(web)
        _keep(cache_file, texts)
    return {key: text.encode() for key, text in texts.items()} | dict(sdk_files(web))


def _build(web: Path) -> dict[str, str]:
    # Here: built pages need none of them, and the models take their time.
    from infra.web_build import openapi
    from infra.web_build.docs import build

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    code = project.get("urls", {}).get("Repository", "")
    openapi.document.cache_clear()  # its texts may have changed
    generated = build.pages(web)
    task = {"web": str(web), "pages": _sources(web, generated), "origin": _ANY_ORIGIN, "code": code}
    made = run_node("the site is", "node", str(_PAGE_BUILDER), text=json.dumps(task))
    if made.returncode:
        hint = " Run `npm ci`." if "ERR_MODULE_NOT_FOUND" in made.stderr else ""
        raise SiteError(f"the site cannot be made.{hint}\n{made.stderr.strip()}")
    files: dict[str, str] = json.loads(made.stdout)
    others = {key: text for key, text in generated.items() if not key.endswith(".html")}
    return others | files | openapi.files()


def _keep(place: Path, made: Mapping[str, str]) -> None:
    """Write a file for other processes; keep only the newest."""
    write_whole(place, json.dumps(made).encode())
    with suppress(FileNotFoundError):  # another process removes old ones too
        oldest_first = sorted(place.parent.glob("*.json"), key=lambda path: path.stat().st_mtime_ns)
        for old in oldest_first[:-_MAX_CACHED]:
            old.unlink()


def _state(web: Path) -> str:
    """Digest of the sources' paths, times and sizes."""
    whole = hashlib.sha256(str(web).encode())
    for path in _inputs(web):
        try:
            status = Path(path).stat()
        except FileNotFoundError:
            continue
        whole.update(f"{path}\0{status.st_mtime_ns}\0{status.st_size}\0".encode())
    return whole.hexdigest()


def _inputs(web: Path) -> Iterator[str]:
    """Paths as texts: they are walked with every page."""
    for folder in (web, ROOT / "docs", Path(__file__).parent, _MODELS):
        for place, folders, names in os.walk(folder):
            folders[:] = sorted(name for name in folders if name != "vendor")
            yield from (f"{place}/{name}" for name in sorted(names) if name.endswith(_INPUTS))
    documents = (entry.source for entry in entries() if entry.source)
    yield from (f"{ROOT}/{name}" for name in ("pyproject.toml", ".build/examples.json", *documents))


def main(folder: Path) -> None:
    """Write the whole site to a folder."""
    shutil.copytree(WEB, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns(*SOURCE_FOLDERS))
    _write(folder, made_files())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
