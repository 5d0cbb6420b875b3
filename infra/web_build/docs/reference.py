"""Pages of the API reference, made of the OpenAPI document: a page a group of calls, and one of all."""

from collections.abc import Iterator, Mapping
from html import escape

from infra.web_build import openapi
from infra.web_build.docs.catalog import FOLDER, address
from infra.web_build.docs.fields import Row, kind, rows, table
from infra.web_build.docs.markdown import Heading, Section, code_block, inline
from infra.web_build.docs.page import page
from infra.web_build.docs.samples import SAMPLE_LANGUAGES, SAMPLE_NAMES, fill, format_json, samples
from infra.web_build.example_calls import Call, calls
from infra.web_build.operation import Node

REFERENCE = f"{FOLDER}reference/index.html"
SCRIPT = f"{FOLDER}reference.js"
_JSON = "application/json"
_MAX_ROWS = 12  # of a field for a body
_CREDENTIALS = {
    "apiToken": "API token",
    "apiTokenInQuery": "API token in the query",
    "sessionId": "session id",
    "managementToken": "management token",
}
_INTRODUCTION = (
    "Every call, field and answer, from the document with which the service checks each request. "
    "The examples are sent to a running service by the project’s tests. Code carries this site’s address "
    "and, once you have made one, your token; <em>Try it</em> sends a request from this page."
)


def pages() -> Mapping[str, str]:
    """Make all pages, by key."""
    examples = {call.name: call for call in calls()}
    made = {REFERENCE: _home()}
    for tag in openapi.document()["tags"]:
        made[_key(tag["name"])] = _group(tag, examples)
    return made


def sections() -> Iterator[tuple[str, Section]]:
    """Yield the folder and the texts of each operation, for the search."""
    for tag in openapi.document()["tags"]:
        for path, method, operation in _operations(tag["name"]):
            fields = _body(operation)
            words = [operation["description"], *(f"{row.name} {row.text}" for row in fields)]
            title = f"{method.upper()} {path}: {operation['summary']}"
            yield f"{_slug(tag['name'])}/", Section(title, operation["operationId"], words)


def _operations(tag: str) -> Iterator[tuple[str, str, Node]]:
    for path, methods in openapi.document()["paths"].items():
        for method, operation in methods.items():
            if operation["tags"] == [tag]:
                yield path, method, operation


def _slug(tag: str) -> str:
    return tag.lower()


def _key(tag: str) -> str:
    return f"{FOLDER}reference/{_slug(tag)}/index.html"


def _home() -> str:
    parts = [
        f"<p>{_INTRODUCTION}</p>\n"
        '<p>Machine-readable: <a href="../../openapi.json">openapi.json</a> (OpenAPI 3.1). '
        'In words: <a href="../api/">The HTTP API</a>.</p>'
    ]
    for tag in openapi.document()["tags"]:
        items = "".join(
            f'<li><a href="{address(REFERENCE, _key(tag["name"]))}#{operation["operationId"]}">'
            f"<code>{_signature(method, path)}</code></a><span>{escape(operation['summary'])}</span></li>"
            for path, method, operation in _operations(tag["name"])
        )
        parts.append(
            f'<h2 id="{_slug(tag["name"])}">{tag["name"]}</h2>\n<p>{escape(tag["description"])}</p>\n'
            f'<ul class="cards calls">{items}</ul>'
        )
    return page(REFERENCE, "API reference", "Every call of the calibDB API.", "\n".join(parts))


def _group(tag: Node, examples: Mapping[str, Call]) -> str:
    operations = list(_operations(tag["name"]))
    shown: dict[str, str] = {}
    body = [
        f'<p>{escape(tag["description"])} <a href="../">All groups</a></p>',
        *(_operation(path, method, node, examples, shown) for path, method, node in operations),
    ]
    headings = [
        Heading(2, f"{method.upper()} {path}", node["operationId"]) for path, method, node in operations
    ]
    title = f"{tag['name']}: API reference"
    key = _key(tag["name"])
    return page(key, title, tag["description"], fill("\n".join(body)), headings, [SCRIPT], uses_service=True)


def _operation(
    path: str, method: str, node: Node, examples: Mapping[str, Call], shown: dict[str, str]
) -> str:
    """Make the section of one call; `shown`: call by answer, of those that the page has had so far."""
    name = node["operationId"]
    call = examples[name]
    parts = [
        f'<section class="operation" aria-labelledby="{name}">',
        f'<h2 id="{name}"><code>{_signature(method, path)}</code></h2>',
        f'<p class="lead">{escape(node["summary"])}</p><p>{inline(node["description"])}</p>',
        f'<p class="muted">Credential: {_credential(node)}</p>',
    ]
    parameters = _parameters(node)
    if parameters:
        parts.append("<h3>Parameters</h3>" + table(parameters, with_required=True))
    if body := _body(node):
        parts.append("<h3>Body</h3>" + table(body, with_required=True))
    parts.append(_samples(name, call))
    parts.append(_answer(node, shown))
    parts.append(_trial(name, path, call, node))
    parts.append("</section>")
    return "\n".join(parts)


def _signature(method: str, path: str) -> str:
    # Long paths break after a slash.
    return f"{method.upper()} {escape(path).replace('/', '/<wbr>')}"


def _credential(node: Node) -> str:
    names = [_CREDENTIALS[one] for each in node.get("security", ()) for one in each if one in _CREDENTIALS]
    return " or ".join(names) or "none"


def _parameters(node: Node) -> list[Row]:
    return [
        Row(each["name"], kind(each["schema"]), each.get("required", False), each["description"])
        for each in node.get("parameters", ())
        if not each.get("deprecated")
    ]


def _body(node: Node) -> list[Row]:
    schema = node.get("requestBody", {}).get("content", {}).get(_JSON, {}).get("schema")
    return list(rows(schema)) if schema else []


def _samples(name: str, call: Call) -> str:
    choices, blocks = [], []
    for index, (label, text) in enumerate(samples(call).items()):
        radio_id = f"{name}-{label}"
        choices.append(
            f'<input type="radio" name="{name}-sample" id="{radio_id}" value="{label}"'
            f'{" checked" if index == 0 else ""}><label for="{radio_id}">{SAMPLE_NAMES[label]}</label>'
        )
        blocks.append(code_block(text, SAMPLE_LANGUAGES[label]))
    return (
        f'<fieldset class="samples"><legend class="unseen">Language of the example</legend>'
        f"{''.join(choices)}{''.join(blocks)}</fieldset>"
    )


def _answer(node: Node, shown: dict[str, str]) -> str:
    parts = ["<h3>Responses</h3>", '<dl class="answers">']
    for status, answer in node["responses"].items():
        parts.append(f"<dt><code>{status}</code></dt><dd>{inline(answer['description'])}</dd>")
    parts.append("</dl>")
    first = next(iter(node["responses"].values()))
    content = first.get("content", {}).get(_JSON, {})
    if "example" in content:
        block = code_block(format_json(content["example"]), "json")
        parts.append(f'<details class="example"><summary>Example response</summary>{block}</details>')
    if schema := content.get("schema"):
        parts.append(_fields(schema["anyOf"][0] if "anyOf" in schema else schema, shown, node))
    return "\n".join(parts)


def _fields(schema: Node, shown: dict[str, str], node: Node) -> str:
    """Make the table of a response's fields, once per page."""
    name = schema.get("$ref", "").rpartition("/")[2]
    if name in shown:
        there = f'<a href="#{shown[name]}">the same fields as above</a>'
        return f"<p>The response has {there}.</p>"
    shown[name] = node["operationId"]
    fields_table = table(list(rows(schema)), with_required=False)
    return f"<details><summary>Fields of the response</summary>{fields_table}</details>"


def _trial(name: str, path: str, call: Call, node: Node) -> str:
    """Make the form that sends the request; `docs/reference.js` shows and reads it."""
    credential = next((one for each in node.get("security", ()) for one in each), "")
    inputs = []
    if credential:
        label = _CREDENTIALS[credential]
        inputs.append(_input(name, "credential", label[0].upper() + label[1:], ""))
    for each in node.get("parameters", ()):
        if not each.get("deprecated"):
            value = {**call.query, **call.path_values}.get(each["name"], "")
            inputs.append(_input(name, f"{each['in']}-{each['name']}", each["name"], value))
    if call.body is not None:
        inputs.append(_body_input(name, format_json(call.body)))
    accept = f' data-accept="{call.accept}"' if call.accept else ""
    return (
        f'<details class="trial"><summary>Try it</summary><form data-operation="{name}" '
        f'data-method="{call.method}" data-path="{escape(path)}" '
        f'data-credential="{credential}"{accept}>{"".join(inputs)}'
        '<div class="actions"><button class="primary" type="submit">Send</button></div>'
        '<div class="trial-answer" role="status"></div></form></details>'
    )


def _body_input(name: str, text: str) -> str:
    input_id = f"{name}-body"
    shown = min(_MAX_ROWS, text.count("\n") + 1)
    return (
        f'<div class="field"><label for="{input_id}">Body</label><textarea id="{input_id}" name="body" '
        f'rows="{shown}" spellcheck="false">{escape(text)}</textarea></div>'
    )


def _input(name: str, field: str, label: str, value: str) -> str:
    input_id = f"{name}-{field}"
    return (
        f'<div class="field"><label for="{input_id}">{escape(label)}</label>'
        f'<input id="{input_id}" name="{field}" value="{escape(value)}"'
        ' autocomplete="off" spellcheck="false">'
        "</div>"
    )
