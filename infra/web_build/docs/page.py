"""Frame of a page under `/docs/`: navigation of all documents, search, contents of this one.

The frame speaks the visitor's language (`web/messages/en/docs.json`), the documents are in English.
"""

from collections.abc import Sequence
from html import escape

from infra.web_build.docs.catalog import FOLDER, GROUPS, address
from infra.web_build.docs.markdown import Heading

GROUP_NAMES = {"start": "Use it", "understand": "Understand it", "project": "The project"}
_MAX_LEVEL = 3  # of the headings in a page's contents
_MIN_CONTENTS = 3  # headings; fewer are seen at once


def page(
    key: str,
    title: str,
    description: str,
    body: str,
    headings: Sequence[Heading] = (),
    scripts: Sequence[str] = (),
    *,
    uses_service: bool = False,
) -> str:
    """Make a page.

    `body`: HTML without the title. `headings`: for the contents. `scripts`: keys of modules besides
    `docs/docs.js`. `uses_service`: as in `Entry`.
    """

    def at(name: str) -> str:
        return address(key, name)

    modules = "".join(
        f'  <script type="module" src="{at(script)}"></script>\n' for script in ("docs/docs.js", *scripts)
    )
    chosen = _token_choice(at("developers/index.html")) if uses_service else ""
    return f"""<!doctype html>
<html lang="en">
<head>
  <title>{escape(title)} · calibDB</title>
  <meta name="description" content="{escape(description)}">
  <link rel="stylesheet" href="{at("docs/docs.css")}">
{modules}</head>
<body>
  <div class="page">
    <header class="masthead"></header>
    <main class="docs">
      <div class="docs-search">
        <form id="search" role="search" hidden>
          <label for="words" data-t="docs.search">Search the documentation</label>
          <input id="words" type="search" autocomplete="off" spellcheck="false"
            placeholder="undistort, ROS, 429"
            aria-describedby="found" aria-keyshortcuts="/">
          <p class="unseen" id="found" role="status"></p>
          <ul class="results" id="results" lang="en" hidden></ul>
        </form>
        <a class="to-contents" href="#all-documents" data-t="docs.all">All documents</a>
      </div>
      <article class="document">
        <h1 lang="en">{escape(title)}</h1>
{chosen}{_contents(headings)}<div lang="en">
{body}
</div>
      </article>
{_navigation(key)}
    </main>
  </div>
</body>
</html>
"""


def _token_choice(developers: str) -> str:
    return f"""<p class="your-token"><label for="token" data-t="docs.token">Token in the examples</label>
<select id="token"><option>cdb_…</option></select>
<a href="{developers}" data-t="docs.make_token">Make a token</a></p>
"""


def _contents(headings: Sequence[Heading]) -> str:
    shown = [heading for heading in headings if heading.level <= _MAX_LEVEL]
    if len(shown) < _MIN_CONTENTS:
        return ""
    least = min(heading.level for heading in shown)
    items = "".join(
        f"<li{' class=sub' if heading.level > least else ''}>"
        f'<a href="#{heading.anchor}">{escape(heading.text)}</a></li>'
        for heading in shown
    )
    summary = '<summary data-t="docs.contents">On this page</summary>'
    return f'<details class="contents">{summary}<ul lang="en">{items}</ul></details>\n'


def _navigation(key: str) -> str:
    groups = []
    for name, entries in GROUPS.items():
        links = "".join(
            f'<li><a href="{address(key, entry.key)}"'
            f"{' aria-current=page' if entry.key == key else ''}>{escape(entry.name)}</a></li>"
            for entry in entries
        )
        is_open = name != "project" or any(entry.key == key for entry in entries)
        groups.append(
            f"<details{' open' if is_open else ''}>"
            f'<summary><h2 data-t="docs.group_{name}">{GROUP_NAMES[name]}</h2></summary>'
            f'<ul lang="en">{links}</ul></details>'
        )
    home = address(key, f"{FOLDER}index.html")
    label = 'aria-label="Documentation" data-t-label="docs.documents"'
    return f"""      <nav class="documents" id="all-documents" {label}>
        <a class="overview" href="{home}" data-t="docs.overview">Overview</a>{"".join(groups)}
      </nav>"""
