"""Jinja templates of pages and of code, in `web/templates/`."""

import json
import re
from collections.abc import Sequence
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from infra.web_build.docs.catalog import ROOT, groups
from infra.web_build.docs.fields import body_rows, parameter_rows, rows
from infra.web_build.docs.markdown import Section, code_block, inline
from infra.web_build.operation import JSON, TOKEN, Operation

SITE = "http://127.0.0.1:8000"
"""Address in all code; the pages put their own in its place."""
_INDENTATION = re.compile(r"(<(pre|textarea)\b.*?</\2>)|\n\s+", re.DOTALL)
"""Indentation of the templates, or a part of a page whose blanks are shown."""
_MARKS = {SITE: "origin", TOKEN: "token"}


def render(template: str, key: str = "", sections: Sequence[Section] = (), **values: Any) -> str:
    """Make a page.

    `key`: of the page, for the navigation. `sections`: for the contents. With `uses_service` the page fills
    the site's address and the visitor's token into its code.
    """
    page = _TEMPLATES.get_template(template).render(
        navigation={name: entries for name, entries in groups().items() if name != "contributors"},
        key=key,
        sections=sections,
        **{"uses_service": False, **values},
    )
    page = _INDENTATION.sub(lambda match: match[1] or "\n", page)
    return re.sub("<pre.*?</pre>", _fill, page, flags=re.DOTALL) if values.get("uses_service") else page


def _fill(block: re.Match[str]) -> str:
    """Mark the places in a block of code that the page fills in: the site's address and the visitor's token.

    Raises ValueError if an address begins otherwise, or is cut by colours.
    """
    code = block[0]
    if "127.0.0.1" in code.replace(SITE, ""):
        raise ValueError(f"an address is not {SITE}, or is cut by colours: {code}")
    for text, name in _MARKS.items():
        code = code.replace(text, f'<span data-fill="{name}">{text}</span>')
    return code


def samples(call: Operation) -> dict[str, str]:
    """Return the request in every language."""
    values = {"call": call, "site": SITE, "headers": _headers(call)}
    return {
        language: _TEMPLATES.get_template(f"docs/samples/{language}.txt").render(values).rstrip("\n")
        for language in ("curl", "fetch", "python")
    }


def _headers(call: Operation) -> dict[str, str]:
    return {
        **({"Authorization": f"Bearer {call.example_credential}"} if call.example_credential else {}),
        **({"Accept": call.example_accept} if call.example_accept else {}),
        **({"Content-Type": JSON} if call.example is not None else {}),
    }


def literal(value: Any, language: str) -> str:
    """Write a value on one line as `json`, `js` or `python`."""
    if isinstance(value, dict):
        names = {name: name if language == "js" else json.dumps(name) for name in value}
        members = ", ".join(f"{names[name]}: {literal(each, language)}" for name, each in value.items())
        return f"{{ {members} }}" if language == "js" else f"{{{members}}}"
    if isinstance(value, list):
        return f"[{', '.join(literal(each, language) for each in value)}]"
    if language == "python" and (value is None or isinstance(value, bool)):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


def format_json(value: Any, pad: str = "") -> str:
    """Write JSON with one member per line, and lists of numbers or texts on one line."""
    inner = f"{pad}  "
    if isinstance(value, dict) and value:
        members = (f"{inner}{json.dumps(name)}: {format_json(each, inner)}" for name, each in value.items())
        return "{\n" + ",\n".join(members) + f"\n{pad}}}"
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        items = (f"{inner}{format_json(each, inner)}" for each in value)
        return "[\n" + ",\n".join(items) + f"\n{pad}]"
    return json.dumps(value, ensure_ascii=False)


_TEMPLATES = Environment(
    loader=FileSystemLoader(ROOT / "web" / "templates"),
    autoescape=select_autoescape(["html"]),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
_TEMPLATES.filters |= {
    "body_rows": body_rows,
    "code": code_block,
    "format_json": format_json,
    "literal": literal,
    "markdown": inline,
    "parameter_rows": parameter_rows,
    "rows": rows,
    "samples": samples,
}
