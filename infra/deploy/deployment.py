"""Deployment, step by step."""

import functools
import os
import shlex
import subprocess
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime

from infra.console import announce
from infra.deploy import account_check, aws, page_token, smoke, smoke_capture
from infra.deploy.aws import DeployError
from infra.deploy.package import (
    ROOT,
    TEMPLATE,
    Template,
    complete_template,
    package_template,
    release_digest,
    write_template,
)
from infra.deploy.prune import prune
from infra.deploy.site import uploads
from infra.deploy.steps import PARAMETERS, Step, Target, parameter_file, steps
from infra.web_build.root_files import contacts, public_settings
from infra.web_build.site import Options


def deploy(target: Target, template: Template | None = None, leave_out: Collection[str] = ()) -> None:
    """Do every step but those of the kinds to `leave_out`; raises DeployError at the first that fails."""
    source = template or complete_template()
    target = find_out(target)
    chosen = [step for step in steps(target) if step.kind not in leave_out]
    for step in announce(f"deploy {target.stack}", chosen, lambda step: step.text):
        _do(step, target, source)


def find_out(target: Target) -> Target:
    """Complete a target by its account: whether the stack exists, and where its site is."""
    stack = target.account.describe()
    if stack.status in aws.UNCREATED:
        return target
    domain = target.parameters.get("DomainName", stack.parameters.get("DomainName", ""))
    host = domain or stack.outputs.get("DistributionDomain")
    return replace(target, exists=True, site=f"https://{host}" if host else None)


def _do(step: Step, target: Target, source: Template) -> None:
    account = target.account
    match step.kind:
        case "account":
            if messages := list(account_check.problems(target, account)):
                raise DeployError("\n".join(messages))
        case "build" | "run":
            parameters = _fill_in(step.parameters, target)
            if parameters:
                PARAMETERS.parent.mkdir(parents=True, exist_ok=True)
                PARAMETERS.write_text(parameter_file(parameters), encoding="utf-8")
            _run(step.command, target)
            values = account.describe().parameters if parameters else {}
            if different := [name for name, value in parameters.items() if values.get(name) != value]:
                raise DeployError(f"the stack has other values than asked for: {', '.join(different)}")
        case "package":
            named = release(target, source)
            values = {**account.describe().parameters, **target.parameters}
            write_template(
                package_template(source, named, traced=values.get("Tracing") == "Active"), TEMPLATE
            )
            print(f"   release {named}")
        case "secrets":
            account.make_secrets()
        case "upload":
            stack = account.describe()
            if not stack.status:
                raise DeployError(f"there is no stack {target.stack}")
            made = stack.outputs
            s3, bucket = account.client("s3"), made["WebBucketName"]
            token = page_token.current_token(made, target.region, aws.settings(s3, bucket))
            if made["Canary"] == "on":
                page_token.give_canary(made, account)
            settings = public_settings(token, stack.parameters)
            contact = made.get("SecurityContact") or stack.parameters.get("OperatorContact")
            options = Options(made["SiteUrl"], contacts(stack.parameters))
            files = uploads(ROOT / "web", settings, contact, datetime.now(UTC), options)
            print(f"   {aws.upload(s3, bucket, files)} files")
        case "invalidate":
            account.invalidate()
        case "protect":
            account.protect()
        case "prune":
            versions, artifacts = prune(account, datetime.now(UTC))
            print(f"   {versions} versions, {artifacts} artifacts")
        case "smoke":
            if messages := list(_smoke(target, source)):
                advice = ["Return to the release before: make deploy ARGS=--back"] if target.exists else []
                raise DeployError("\n".join([*messages, *advice]))


def release(target: Target, source: Template) -> str:
    """Digest of what is deployed; raises KeyError if the address of the site is needed and not known."""
    stack = target.account.describe()
    values = {**stack.parameters, **target.effective}
    if target.site is None and (url := stack.outputs.get("SiteUrl")):
        values["GuidanceUrl"] = f"{url}/calibrate/"
    return release_digest(source, values)


def _smoke(target: Target, source: Template) -> Iterator[str]:
    account = target.account
    made = account.outputs()
    site = smoke.Site(made["SiteUrl"], made["DistributionDomain"])
    yield from smoke.unreleased(account.releases(), release(target, source))
    yield from smoke.problems(smoke.make_requester(site.url, site.distribution), site)
    # Pages of other origins may use the API's own address, where the edge answers no preflights.
    at_api = smoke.make_requester(made["ApiUrl"].removesuffix("/v1"))
    yield from (f"{made['ApiUrl']}: {problem}" for problem in smoke.preflight_problems(at_api, "/v1/lookup"))
    settings = aws.settings(account.client("s3"), made["WebBucketName"])
    names = {
        each["LogicalResourceId"]: each["PhysicalResourceId"] for each in account.resources(aws.FUNCTION)
    }
    remove = functools.partial(smoke_capture.remove, made, target.region, names["RefitFunction"])
    yield from smoke_capture.problems(site, settings.get("token", ""), remove)


def _fill_in(parameters: Mapping[str, str], target: Target) -> dict[str, str]:
    """Fill in the stack's outputs and the version of the edge's secret."""
    values: dict[str, str] = {}
    text = "".join(parameters.values())
    if "{SiteUrl}" in text:
        values["{SiteUrl}"] = target.account.outputs()["SiteUrl"]
    if "{EdgeSecretVersion}" in text:
        values["{EdgeSecretVersion}"] = str(target.account.edge_secret_version())
    filled = dict(parameters)
    for place, value in values.items():
        filled = {name: content.replace(place, value) for name, content in filled.items()}
    return filled


def _run(command: Sequence[str], target: Target) -> None:
    quiet = {**os.environ, "SAM_CLI_TELEMETRY": "0"}
    done = subprocess.run(command, cwd=ROOT, env=quiet, check=False)
    if done.returncode:
        said = f"{shlex.join(command)} failed"
        if command[1:2] == ["deploy"]:
            said = "\n".join([said, *account_check.explain(target.account.failures())])
        raise DeployError(said)
