"""Requests of the API reference as code: curl, fetch in a browser or Node, and Python with httpx."""

import json
from typing import Any

from infra.web_build.example_calls import TOKEN, Call

SITE = "http://127.0.0.1:8000"
"""Address in all code; the pages put their own in its place."""
JSON = "application/json"

SAMPLE_LANGUAGES = {"curl": "sh", "fetch": "js", "python": "python"}
"""Languages of the samples, as a highlighter knows them."""
SAMPLE_NAMES = {"curl": "curl", "fetch": "fetch", "python": "Python"}


def samples(call: Call) -> dict[str, str]:
    """Return the request in every language."""
    return {"curl": _curl(call), "fetch": _fetch(call), "python": _httpx(call)}


def _curl(call: Call) -> str:
    method = "" if call.method == ("GET" if call.body is None else "POST") else f" -X {call.method}"
    lines = [f"curl -s{' -G' if call.query else ''}{method} {SITE}{call.path}"]
    lines += [f'-H "{name}: {value}"' for name, value in _headers(call).items()]
    lines += [f'--data-urlencode "{name}={value}"' for name, value in call.query.items()]
    if call.body is not None:
        lines.append(f"-d '{_json(call.body)}'")
    return " \\\n  ".join(lines)


def _headers(call: Call) -> dict[str, str]:
    return {
        **({"Authorization": f"Bearer {call.credential}"} if call.credential else {}),
        **({"Accept": call.accept} if call.accept else {}),
        **({"Content-Type": JSON} if call.body is not None else {}),
    }


def _fetch(call: Call) -> str:
    lines = []
    where = f'"{SITE}{call.path}"'
    if call.query:
        lines.append(f"const query = new URLSearchParams({_javascript(dict(call.query))});")
        where = f"`{SITE}{call.path}?${{query}}`"
    options = [f'method: "{call.method}",'] if call.method != "GET" else []
    names = {"Authorization": "authorization", "Accept": "accept", "Content-Type": '"content-type"'}
    headers = [f'{names[name]}: "{value}"' for name, value in _headers(call).items()]
    options += [f"headers: {{ {', '.join(headers)} }},"] if headers else []
    if call.body is not None:
        options.append(f"body: JSON.stringify({_javascript(call.body, 1)}),")
    arguments = "".join(f"\n  {option}" for option in options)
    lines.append(
        f"const response = await fetch({where}{f', {{{arguments}{chr(10)}}}' if arguments else ''});"
    )
    lines.append("console.log(response.status, await response.text());")
    return "\n".join(lines)


def _httpx(call: Call) -> str:
    headers = [f'"{name}": "{value}"' for name, value in _headers(call).items() if name != "Content-Type"]
    options = [f"headers={{{', '.join(headers)}}},"] if headers else []
    options += [f"params={_python(dict(call.query))},"] if call.query else []
    options += [f"json={_python(call.body)},"] if call.body is not None else []
    options += ["timeout=30,"]  # s, as long as the service may take; httpx waits for 5 otherwise
    function = f"httpx.{call.method.lower()}"
    where = f'"{SITE}{call.path}"'
    arguments = "".join(f"\n    {option}" for option in (f"{where},", *options)) + "\n"
    return f"import httpx\n\nresponse = {function}({arguments})\nprint(response.status_code, response.text)"


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


def _json(value: Any) -> str:
    if not isinstance(value, dict):
        return json.dumps(value, ensure_ascii=False)
    members = (f'  "{name}": {json.dumps(each, ensure_ascii=False)}' for name, each in value.items())
    return "{\n" + ",\n".join(members) + "\n}"


def _javascript(value: Any, depth: int = 0) -> str:
    pad = "  " * depth
    members = (f"{pad}  {name}: {_inline(each)}," for name, each in value.items())
    return "{\n" + "\n".join(members) + f"\n{pad}}}"


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name}: {_inline(each)}" for name, each in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(_inline, value))}]"
    return json.dumps(value, ensure_ascii=False)


def _python(value: Any) -> str:
    if not isinstance(value, dict):
        return _literal(value)
    members = (f"        {json.dumps(name)}: {_literal(each)}," for name, each in value.items())
    return "{\n" + "\n".join(members) + "\n    }"


def _literal(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)}: {_literal(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value) if not isinstance(value, str) else json.dumps(value, ensure_ascii=False)


_MARKS = {SITE: "origin", TOKEN: "token"}


def fill(html: str) -> str:
    """Mark the places in blocks of code that the page fills in: the site's address and the visitor's token.

    Raises ValueError if an address begins otherwise, or is cut by colours.
    """
    parts = html.split("<pre")
    for index, part in enumerate(parts[1:], 1):
        block, closing, rest = part.partition("</pre>")
        if "127.0.0.1" in block.replace(SITE, ""):
            raise ValueError(f"an address is not {SITE}, or is cut by colours: {block}")
        for text, name in _MARKS.items():
            block = block.replace(text, f'<span data-fill="{name}">{text}</span>')
        parts[index] = block + closing + rest
    return "<pre".join(parts)
