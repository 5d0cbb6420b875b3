"""Package of a release: the template that is deployed, and the digest that names the release."""

import argparse
import copy
import hashlib
import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from infra.deploy.template import parse
from infra.web_build.site import WEB, made_files
from infra.web_build.site_headers import CONTENT_SECURITY_POLICY

ROOT = Path(__file__).resolve().parents[2]
TEMPLATE = ROOT / ".build" / "deploy" / "template.yaml"
DASHBOARD = ROOT / "infra" / "deploy" / "dashboard.json"
# Resources that stand in files of their own
FRAGMENTS = (
    *(ROOT / "infra" / "edge" / f"{name}.yaml" for name in ("headers", "caching", "distribution", "logs")),
    *(
        ROOT / "infra" / "deploy" / f"{name}.yaml"
        for name in ("alarms", "canary", "monitoring", "policies", "replication")
    ),
)
UNRELEASED = "source"  # the release of an unpackaged template
# What a release consists of besides its template and parameters: code as it is uploaded
_CODE = (ROOT / ".build" / "layers", ROOT / "functions")
_RELEASE_DIGITS = 16
_FUNCTION_TYPE = "AWS::Serverless::Function"
_ALARM = {
    "EvaluationPeriods": 1,
    "Threshold": 1,
    "ComparisonOperator": "GreaterThanOrEqualToThreshold",
    "TreatMissingData": "notBreaching",
    "AlarmActions": [{"Ref": "AlarmTopic"}],
}
_REFERENCE = re.compile(r'(?:"Ref": "|\$\{)(\w+)["}]')  # in a template as JSON: `!Ref` and `!Sub`
# Folders of code, and where they are from the folder of `TEMPLATE`
_PLACES = {"functions/": "../../functions/", "infra/": "../../infra/", "layers/": "../layers/"}

Template = dict[str, Any]
"""A template as `parse` returns it."""


def complete_template() -> Template:
    """Return the template with its parts in other files: resources, the dashboard, the edge's functions.

    CloudFormation requires bodies and code as strings, of which `AWS::Include` makes maps.
    """
    document = parse(ROOT / "template.yaml")
    resources = document["Resources"]
    for path in FRAGMENTS:
        resources |= _resources(parse(path))
    resources["Dashboard"]["Properties"]["DashboardBody"] = {"Fn::Sub": DASHBOARD.read_text(encoding="utf-8")}
    for name in ("PageHeaders", "WorkerHeaders"):
        policies = resources[name]["Properties"]["ResponseHeadersPolicyConfig"]["SecurityHeadersConfig"]
        policies["ContentSecurityPolicy"]["ContentSecurityPolicy"] = CONTENT_SECURITY_POLICY
    index = "index.html"
    # Folders of the site with a page, as they stand in addresses
    pages = json.dumps(sorted(f"/{key.removesuffix(index)}" for key in made_files() if key.endswith(index)))
    for resource in resources.values():
        if resource["Type"] == "AWS::CloudFront::Function":
            properties = resource["Properties"]
            properties["FunctionCode"] = _edge_function(ROOT / properties["FunctionCode"], pages)
        if resource["Type"] == "AWS::Lambda::Function":
            code = resource["Properties"]["Code"]
            code["ZipFile"] = (ROOT / code["ZipFile"]).read_text(encoding="utf-8")
    return document


def _resources(fragment: Template) -> Template:
    resources: Template = dict(fragment["Resources"])
    for name, alarm in fragment.get("Alarms", {}).items():
        condition = {"Condition": alarm.pop("Condition")} if "Condition" in alarm else {}
        resources[name] = {"Type": "AWS::CloudWatch::Alarm", **condition, "Properties": _ALARM | alarm}
    for name, statements in fragment.get("Policies", {}).items():
        allowed = [{"Effect": "Allow", **statement} for statement in statements]
        document = {"Version": "2012-10-17", "Statement": allowed}
        resources[name] = {"Type": "AWS::IAM::ManagedPolicy", "Properties": {"PolicyDocument": document}}
    return resources


def package_template(complete: Template, release: str = UNRELEASED, *, traced: bool = False) -> Template:
    """Convert the complete template to the one in `.build/deploy`, of this release.

    Its paths are relative to that folder, its layers the built ones. Functions may write traces only if
    `traced`.
    """
    document = copy.deepcopy(complete)
    functions = document["Globals"]["Function"]
    functions["Environment"]["Variables"]["RELEASE"] = release
    if not traced:
        del functions["Tracing"]
    for resource in document["Resources"].values():
        properties = resource["Properties"]
        for key in properties.keys() & {"CodeUri", "ContentUri", "DefinitionUri"}:
            folder, slash, rest = properties[key].partition("/")
            properties[key] = _PLACES[folder + slash] + rest
    return document


def write_template(document: Template, path: Path) -> None:
    """Write a template as JSON, which is YAML."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(document, indent=1), encoding="utf-8")


def release_digest(complete: Template, parameters: Mapping[str, str], code: Iterable[Path] = _CODE) -> str:
    """Digest of all that functions run with: code, layers, the template, and the parameters they name.

    SAM makes a new version of a function when the function's own package or its environment as written
    changes. This digest in the environment makes it do so when a layer or a parameter's value changes.
    `parameters` replace the template's defaults. Of the folders `code`, names and contents of all files
    count.
    """
    values = {n: str(p.get("Default", "")) for n, p in complete["Parameters"].items()} | dict(parameters)
    named = sorted(set(_REFERENCE.findall(json.dumps(_of_functions(complete)))) & values.keys())
    whole = hashlib.sha256(json.dumps([complete, [(n, values[n]) for n in named]]).encode())
    for folder in code:
        # Compiled modules are part of the layers; in `functions/` a test run leaves them.
        uncounted = {"__pycache__"} if folder.name == "functions" else set()
        for path in sorted(folder.rglob("*")):
            if path.is_file() and not uncounted.intersection(path.relative_to(folder).parts):
                content = path.read_bytes()
                whole.update(f"\0{path.relative_to(folder).as_posix()}\0{len(content)}\0".encode())
                whole.update(content)
    return whole.hexdigest()[:_RELEASE_DIGITS]


def _of_functions(document: Mapping[str, Any]) -> list[Any]:
    functions = [r["Properties"] for r in document["Resources"].values() if r["Type"] == _FUNCTION_TYPE]
    everywhere = document.get("Globals", {}).get("Function", {})
    # How calls move to a release is not part of it.
    return [{k: v for k, v in f.items() if k != "DeploymentPreference"} for f in (everywhere, *functions)]


def _edge_function(path: Path, pages: str) -> str:
    missing = json.dumps((WEB / "404.html").read_text(encoding="utf-8"), ensure_ascii=False)
    code = path.read_text(encoding="utf-8")
    return code.replace("PAGES = []", f"PAGES = {pages}").replace('NOT_FOUND = ""', f"NOT_FOUND = {missing}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the complete template to the file named, for programs that check it."""
    parser = argparse.ArgumentParser(prog="python -m infra.deploy.package", description=main.__doc__)
    parser.add_argument("file", type=Path)
    write_template(complete_template(), parser.parse_args(arguments).file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
