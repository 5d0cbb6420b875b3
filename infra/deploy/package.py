"""Package of a release: the template that is deployed, and the digest that names the release."""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from infra.deploy.template import parse_text
from infra.web_build.site import WEB, page_keys

ROOT = Path(__file__).resolve().parents[2]
TEMPLATE = ROOT / ".build" / "deploy" / "template.yaml"
DASHBOARD = ROOT / "infra" / "deploy" / "dashboard.json"
# Resources that stand in files of their own
FRAGMENTS = (
    *(
        ROOT / "infra" / "edge" / name
        for name in ("headers.yaml", "caching.yaml", "distribution.yaml", "logs.yaml")
    ),
    *(
        ROOT / "infra" / "deploy" / name
        for name in (
            *("alarms.yaml", "canary.yaml", "cutoff.yaml", "monitoring.yaml", "policies.yaml"),
            "replication.yaml",
        )
    ),
)
UNRELEASED = "source"  # the release of an unpackaged template
# What a release consists of besides its template and parameters: code as it is uploaded
_CODE = (ROOT / ".build" / "layers", ROOT / "functions")
_RELEASE_DIGITS = 16
_FUNCTION_TYPE = "AWS::Serverless::Function"
_TRACING = "    Tracing: !Ref Tracing\n"
_UNCOUNTED = ("__pycache__",)  # of `functions/`: a test run leaves it there


def complete_template(source: str) -> str:
    """Insert into the template what stands in files of its own.

    These are resources, the body of the dashboard, and the edge's functions: CloudFormation wants bodies and
    code as strings, of which `AWS::Include` makes maps.
    """
    fragments = "\n".join(path.read_text(encoding="utf-8").partition("Resources:\n")[2] for path in FRAGMENTS)
    whole = source.replace("\nOutputs:\n", f"\n{fragments}\nOutputs:\n")
    dashboard = textwrap.indent(DASHBOARD.read_text(encoding="utf-8"), " " * 8)
    whole = re.sub(r"DashboardBody: !Sub '.*'\n", lambda _: f"DashboardBody: !Sub |\n{dashboard}", whole)
    inline = partial(_inline_function, pages=json.dumps(_pages()))
    return re.sub(r"FunctionCode: (infra/edge/\S+\.js)\n", inline, whole)


def package_template(complete: str, release: str = UNRELEASED, *, traced: bool = False) -> str:
    """Convert the complete template to the one in `.build/deploy`, of this release.

    Its paths are relative to that folder; its layers are the built ones. Only with `traced` may functions
    write traces.
    """
    if not traced:
        complete = complete.replace(_TRACING, "")
    return (
        complete.replace(f"        RELEASE: {UNRELEASED}\n", f'        RELEASE: "{release}"\n')
        .replace("DefinitionUri: infra/", "DefinitionUri: ../../infra/")
        .replace("CodeUri: functions/", "CodeUri: ../../functions/")
        .replace("ContentUri: layers/service/", "ContentUri: ../layers/service/")
        .replace("ContentUri: layers/solver/", "ContentUri: ../layers/solver/")
    )


def release_digest(complete: str, parameters: Mapping[str, str], code: Iterable[Path] = _CODE) -> str:
    """Digest of all that functions run with: code, layers, the template, and the parameters they name.

    SAM makes a new version of a function when the function's own package or its environment as written
    changes. This digest in the environment makes it do so when a layer or a parameter's value changes.

    Parameters
    ----------
    complete
        The complete template.
    parameters
        Values over the template's defaults; those that no function names change nothing.
    code
        Folders whose files count, names and contents.
    """
    document = parse_text(complete)
    values = {n: str(p.get("Default", "")) for n, p in document["Parameters"].items()} | dict(parameters)
    named = sorted(set(_references(_of_functions(document))) & values.keys())
    whole = hashlib.sha256(json.dumps([complete, [(n, values[n]) for n in named]]).encode())
    for folder in code:
        for path in sorted(folder.rglob("*")):
            if path.is_file() and not set(path.relative_to(folder).parts) & set(_excluded_folders(folder)):
                content = path.read_bytes()
                whole.update(f"\0{path.relative_to(folder).as_posix()}\0{len(content)}\0".encode())
                whole.update(content)
    return whole.hexdigest()[:_RELEASE_DIGITS]


def _excluded_folders(folder: Path) -> tuple[str, ...]:
    """Names of folders that are not part of the code; in the layers, compiled modules are."""
    return _UNCOUNTED if folder.name == "functions" else ()


def _of_functions(document: Mapping[str, Any]) -> list[Any]:
    functions = [r["Properties"] for r in document["Resources"].values() if r["Type"] == _FUNCTION_TYPE]
    everywhere = document.get("Globals", {}).get("Function", {})
    # How calls move to a release is not part of it.
    return [{k: v for k, v in f.items() if k != "DeploymentPreference"} for f in (everywhere, *functions)]


def _references(value: Any) -> Iterator[str]:
    """Yield the names in every `!Ref` and `!Sub` of a template's value."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if key == "Ref":
                yield inner
            elif key == "Fn::Sub":
                yield from re.findall(r"\$\{(\w+)\}", inner if isinstance(inner, str) else inner[0])
            yield from _references(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from _references(inner)


def _inline_function(match: re.Match[str], pages: str) -> str:
    code = (
        (ROOT / match[1])
        .read_text(encoding="utf-8")
        .replace("PAGES = []", f"PAGES = {pages}")
        .replace(
            'NOT_FOUND = ""',
            f"NOT_FOUND = {json.dumps((WEB / '404.html').read_text('utf-8'), ensure_ascii=False)}",
        )
    )
    return f"FunctionCode: |\n{textwrap.indent(code, ' ' * 8)}"


def _pages() -> list[str]:
    """List the folders of the site that hold a page, as they stand in addresses."""
    index = "index.html"
    return sorted(f"/{key.removesuffix(index)}" for key in page_keys() if key.endswith(index))


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the complete template to the file named, for programs that check it."""
    parser = argparse.ArgumentParser(prog="python -m infra.deploy.package", description=main.__doc__)
    parser.add_argument("file", type=Path)
    options = parser.parse_args(arguments)
    options.file.parent.mkdir(parents=True, exist_ok=True)
    options.file.write_text(complete_template((ROOT / "template.yaml").read_text(encoding="utf-8")), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
