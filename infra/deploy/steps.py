"""Steps of a deployment, in order; nothing is run here."""

import functools
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from infra.deploy.aws import Account
from infra.deploy.package import ROOT, TEMPLATE

_SAM = ".build/sam/bin/sam"  # `make deploy` installs it
PARAMETERS = ROOT / ".build" / "parameters.yaml"  # written before each command that reads it
_FIREWALL_REGION = "us-east-1"  # the only one in which a web ACL for CloudFront can be made
ROLLOUT = "Canary10Percent5Minutes"  # default
Kind = Literal[
    "account", "build", "run", "package", "secrets", "upload", "invalidate", "protect", "prune", "smoke"
]


@dataclass(frozen=True)
class Target:
    """Target of a deployment.

    `parameters` replace the template's defaults. `site`: address without slash, None if CloudFront assigns
    it, at the first deployment. `exists`: True if the stack exists already.
    """

    stack: str
    region: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    site: str | None = None
    exists: bool = False

    @functools.cached_property
    def account(self) -> Account:
        """The account, as the operator's credentials name it."""
        return Account(self.stack, self.region)

    @property
    def effective(self) -> dict[str, str]:
        """The parameters, and those that each deployment sets.

        CloudFormation keeps the value of a parameter that is not named. `Rollout` applies to one deployment.
        """
        defaults = {"GuidanceUrl": f"{self.site}/calibrate/"} if self.site else {}
        if self.region != _FIREWALL_REGION:
            defaults["WafRate"] = "0"
        return {**defaults, "EdgeSecretVersion": "{EdgeSecretVersion}", "Rollout": ROLLOUT, **self.parameters}


@dataclass(frozen=True)
class Step:
    """A command with the template's parameters, or calls to AWS."""

    kind: Kind
    text: str
    command: tuple[str, ...] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)


def steps(target: Target) -> Iterator[Step]:
    """Yield the steps; each is idempotent, so an interrupted deployment is restarted."""
    yield Step("account", "check that the account can host the stack; nothing is created yet")
    yield Step("build", "build both layers for arm64 and check their sizes", ("make", "layers"))
    yield Step("package", "name the release, and write its template")
    place = str(TEMPLATE.relative_to(ROOT))
    yield Step(
        "run",
        "check the template",
        (_SAM, "validate", "--lint", "--template-file", place, "--region", target.region),
    )
    yield Step(
        "secrets",
        f"make the secrets under /calibdb/{target.stack} that are not there: "
        "SESSION_SECRETS, CONTRIBUTOR_SECRET, EDGE_SECRETS, EDGE_SECRET",
    )
    if region := target.parameters.get("ReplicaRegion"):
        command = _deploy("infra/deploy/replica.yaml", f"{target.stack}-replica", region)
        values = ("--parameter-overrides", f"Stack={target.stack}")
        yield Step("run", f"make the bucket for the replica in {region}", (*command, *values))
    yield Step("run", "create or change the stack", _command(target), target.effective)
    if target.site is None:
        yield Step("package", "name the release again: its functions learn where the site is")
        # There are no calls to move gradually yet.
        parameters = {**target.effective, "GuidanceUrl": "{SiteUrl}/calibrate/", "Rollout": "AllAtOnce"}
        command = _command(target, first=False)
        yield Step("run", "give the functions the address of the site", command, parameters)
    yield Step("upload", "upload web/, what pages load before the pages, and a token for them")
    yield Step("invalidate", "have the edge forget what it kept")
    yield Step("protect", "protect stack and table from deletion")
    yield Step("prune", "remove versions and artifacts of earlier deployments")
    yield Step("smoke", "ask the site and the API whether they do what they must")


def _command(target: Target, *, first: bool = True) -> tuple[str, ...]:
    needed = ("--capabilities", "CAPABILITY_IAM", "--resolve-s3", "--s3-prefix", target.stack)
    return (
        *_deploy(str(TEMPLATE.relative_to(ROOT)), target.stack, target.region, needed),
        # A creation that fails leaves nothing behind that stands in the way of the next.
        *(("--on-failure", "DELETE") if first and not target.exists else ()),
        *("--parameter-overrides", f"file://{PARAMETERS.relative_to(ROOT)}"),
    )


def _deploy(file: str, stack: str, region: str, needed: tuple[str, ...] = ()) -> tuple[str, ...]:
    named = ("--template-file", file, "--stack-name", stack, "--region", region)
    return (_SAM, "deploy", *named, *needed, "--no-confirm-changeset", "--no-fail-on-empty-changeset")


def parameter_file(parameters: Mapping[str, str]) -> str:
    """Text of a parameter file, as the SAM CLI reads it (YAML).

    The CLI removes wrapping quotes and unescapes a backslash before a blank or a quote, twice for a file
    (`CfnParameterOverridesType.convert`). So each value is quoted twice.
    """
    quoted = {name: _quoted(_quoted(value)) for name, value in sorted(parameters.items())}
    return json.dumps(quoted, indent=1, ensure_ascii=False)


def _quoted(value: str) -> str:
    return '"' + re.sub(r"\\(?=[ \"'])", r"\\\\", value) + '"'
