"""Steps of a deployment, in order; nothing is run here."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

ROOT = Path(__file__).resolve().parents[2]
TEMPLATE = ROOT / ".build" / "deploy" / "template.yaml"
DASHBOARD = ROOT / "infra" / "deploy" / "dashboard.json"
_SAM = ".build/sam/bin/sam"  # `make deploy` installs it
Kind = Literal["run", "secrets", "upload", "invalidate", "smoke"]


@dataclass(frozen=True)
class Target:
    """Target of a deployment: stack, region, parameters.

    Attributes
    ----------
    stack, region
        Name and place of the CloudFormation stack.
    parameters
        Of the template, over their defaults.
    site
        Address of the site without slash; None where CloudFront makes one up, at the first deployment.
    """

    stack: str
    region: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    site: str | None = None


@dataclass(frozen=True)
class Step:
    """One thing to do: a command, or something that is done with AWS's interface."""

    kind: Kind
    text: str
    command: tuple[str, ...] = ()


def steps(target: Target) -> Iterator[Step]:
    """Yield the steps; each can be done again, so a deployment that broke off is started anew."""
    yield Step("run", "build both layers for arm64 and check their sizes", ("make", "layers"))
    place = str(TEMPLATE.relative_to(ROOT))
    yield Step(
        "run",
        "check the template",
        (_SAM, "validate", "--lint", "--template-file", place, "--region", target.region),
    )
    yield Step(
        "secrets",
        f"make the secrets under /calibdb/{target.stack} that are not there: "
        "SESSION_SECRETS, CONTRIBUTOR_SECRET, EDGE_SECRET",
    )
    yield _deploy(target)
    if target.site is None:
        yield Step("run", "tell the functions where the site is, now that it has an address", _again(target))
    yield Step("upload", "upload web/, what pages load before the pages, and a token for them")
    yield Step("invalidate", "have the edge forget what it kept")
    yield Step("smoke", "ask the site and the API whether they are there")


def package_template(template: str) -> str:
    """Convert the template to the one in `.build/deploy`.

    Its paths are relative to that folder, its layers are the built ones, and the body of the dashboard is
    inlined: `AWS::Include` inserts a map, and CloudFormation wants the body as a string.
    """
    dashboard = f"DashboardBody: !Sub |\n{textwrap.indent(DASHBOARD.read_text(encoding='utf-8'), ' ' * 8)}"
    return (
        re.sub(r"DashboardBody: !Sub '.*'\n", lambda _: dashboard, template)
        .replace("DefinitionUri: infra/", "DefinitionUri: ../../infra/")
        .replace("CodeUri: functions/", "CodeUri: ../../functions/")
        .replace("ContentUri: layers/service/", "ContentUri: ../layers/service/")
        .replace("ContentUri: layers/solver/", "ContentUri: ../layers/solver/")
    )


def _deploy(target: Target) -> Step:
    return Step("run", "create or change the stack", _command(target, target.parameters))


def _again(target: Target) -> tuple[str, ...]:
    return _command(target, {**target.parameters, "GuidanceUrl": "{SiteUrl}/calibrate/"})


def _command(target: Target, parameters: Mapping[str, str]) -> tuple[str, ...]:
    site = {"GuidanceUrl": f"{target.site}/calibrate/"} if target.site else {}
    overrides = [f"{name}={value}" for name, value in sorted({**site, **parameters}.items())]
    return (
        _SAM,
        "deploy",
        *("--template-file", str(TEMPLATE.relative_to(ROOT))),
        *("--stack-name", target.stack),
        *("--region", target.region),
        *("--capabilities", "CAPABILITY_IAM"),
        "--resolve-s3",
        "--no-confirm-changeset",
        "--no-fail-on-empty-changeset",
        *(("--parameter-overrides", *overrides) if overrides else ()),
    )
