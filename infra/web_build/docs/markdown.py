"""Markdown as HTML: anchors as GitHub makes them, links between documents, code coloured by classes.

The parser is markdown-it-py (CommonMark with tables), the highlighter Pygments. Nothing has a `style`
attribute, which the policy of the pages forbids.
"""

import html
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name

Link = Callable[[str], str | None]
"""Address of a link's target on the site; None if the site has no such page."""

_LANGUAGES = ("sh", "js", "html", "python", "json", "webidl")


# Spans that no rule colours: blanks, names, operators, punctuation
_PLAIN_SPAN = re.compile(r'<span class="(?:w|n|nx|o|p|err)">([^<]*)</span>')


@dataclass
class Section:
    """Text under one heading, for contents and search. The first has the document's title, and no anchor."""

    level: int
    title: str
    anchor: str
    text: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Document:
    """Rendered document."""

    title: str
    html: str
    sections: tuple[Section, ...]


def render(source: str, link: Link) -> Document:
    """Render a document whose first heading is its title, which is left to the page."""
    tokens = _parser().parse(source)
    sections = _outline(tokens)
    title = sections[0].title if sections and sections[0].level == 1 else ""
    if title:
        del tokens[:3]
    for token in tokens:
        _mend(token, link)
    renderer: Any = _Renderer()
    body = renderer.render(tokens, _parser().options, {})
    return Document(title, body, tuple(sections))


def _slug(text: str, taken: set[str]) -> str:
    base = re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")
    anchor, count = base, 0
    while anchor in taken:
        count += 1
        anchor = f"{base}-{count}"
    taken.add(anchor)
    return anchor


def code(text: str, language: str) -> str:
    """Colour code by the classes of Pygments; plain where the language is not known."""
    if language not in _LANGUAGES:
        return html.escape(text, quote=False)
    lexer = get_lexer_by_name(language, stripnl=False)
    coloured = str(highlight(text, lexer, HtmlFormatter(nowrap=True))).rstrip("\n")
    return _PLAIN_SPAN.sub(r"\1", coloured)


def code_block(text: str, language: str) -> str:
    """Make a block of code with its language; the page adds what copies it."""
    kind = f' data-language="{language}"' if language else ""
    inner = code(text.rstrip("\n"), language)
    return f'<div class="block"{kind}><pre tabindex="0"><code>{inner}</code></pre></div>\n'


@cache
def _parser() -> MarkdownIt:
    # Comments mark the parts that benches write; only they are accepted as HTML, and dropped.
    return MarkdownIt("commonmark", {"html": True}).enable("table")


def _outline(tokens: Sequence[Token]) -> list[Section]:
    sections: list[Section] = []
    taken: set[str] = set()
    for index, token in enumerate(tokens):
        if token.type == "inline" and tokens[index - 1].type == "heading_open":
            heading, text = tokens[index - 1], _plain(token)
            anchor, level = _slug(text, taken), int(heading.tag[1])
            heading.attrSet("id", anchor)
            sections.append(Section(level, text, "" if level == 1 else anchor))
        elif token.type in {"inline", "fence"} and sections:
            sections[-1].text.append(_plain(token) if token.type == "inline" else token.content)
    return sections


def _plain(token: Token) -> str:
    """Return the text of inline content without its marks."""
    texts = {"softbreak": " ", "hardbreak": " "}
    parts = [
        child.content if child.type in {"text", "code_inline"} else texts.get(child.type, "")
        for child in token.children or ()
    ]
    return "".join(parts).strip()


def _mend(token: Token, link: Link) -> None:
    """Point links at pages, and replace what our policy forbids."""
    style = str(token.attrGet("style") or "")
    if style.startswith("text-align:"):
        del token.attrs["style"]
        token.attrJoin("class", style.removeprefix("text-align:"))
    open_links: list[bool] = []
    for child in token.children or ():
        if child.type == "image":
            source = str(child.attrGet("src"))
            child.attrSet("src", link(source) or source)
        elif child.type == "link_open":
            target = link(str(child.attrGet("href")))
            open_links.append(target is not None)
            if target is None:
                child.type, child.tag, child.nesting = "text", "", 0
            else:
                child.attrSet("href", target)
        elif child.type == "link_close" and not open_links.pop():
            child.type, child.tag, child.nesting = "text", "", 0


class _Renderer(RendererHTML):
    """Renderer with our code blocks, tables that scroll, and anchors to copy."""

    def fence(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        info = tokens[idx].info.split()
        return code_block(tokens[idx].content, info[0] if info else "")

    def html_block(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        content = tokens[idx].content.strip()
        return "" if content.startswith("<!--") else html.escape(content, quote=False)

    html_inline = html_block

    def table_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return '<div class="wide"><table>\n'

    def table_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</table></div>\n"

    def th_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        # An empty head is not a header cell.
        kind = tokens[idx].attrGet("class")
        self._empty = not tokens[idx + 1].content
        tag = "td" if self._empty else 'th scope="col"'
        return f"<{tag}{f' class={chr(34)}{kind}{chr(34)}' if kind else ''}>"

    def th_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</td>\n" if self._empty else "</th>\n"


def inline(text: str, link: Link = lambda _: None) -> str:
    """Render one line of Markdown, by default without links."""
    tokens = _parser().parseInline(text)
    for token in tokens:
        _mend(token, link)
    renderer: Any = _Renderer()
    return str(renderer.render(tokens, _parser().options, {}))
