"""Deployment, step by step."""

import functools
import os
import shlex
import subprocess
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import boto3

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
    stack = _describe(target)
    if stack is None or stack.status in aws.UNCREATED:
        return target
    domain = target.parameters.get("DomainName", stack.parameters.get("DomainName", ""))
    host = domain or stack.outputs.get("DistributionDomain")
    return replace(target, exists=True, site=f"https://{host}" if host else None)


def _client(service: str, target: Target) -> Any:
    make: Any = boto3.client  # whose types know only literal names
    return make(service, target.region)


def _outputs(target: Target) -> Mapping[str, str]:
    return aws.outputs(_client("cloudformation", target), target.stack)


def _describe(target: Target) -> aws.Stack | None:
    return aws.describe(_client("cloudformation", target), target.stack)


def _do(step: Step, target: Target, source: Template) -> None:
    region, stack = target.region, target.stack
    match step.kind:
        case "account":
            if messages := list(account_check.problems(target, account_check.clients(region))):
                raise DeployError("\n".join(messages))
        case "build" | "run":
            parameters = _fill_in(step.parameters, target)
            if parameters:
                PARAMETERS.parent.mkdir(parents=True, exist_ok=True)
                PARAMETERS.write_text(parameter_file(parameters), encoding="utf-8")
            _run(step.command, target)
            if different := _different(parameters, target):
                raise DeployError(f"the stack has other values than asked for: {', '.join(different)}")
        case "package":
            print(f"   release {_package(target, source)}")
        case "secrets":
            aws.make_secrets(_client("ssm", target), stack)
        case "upload":
            if (described := _describe(target)) is None:
                raise DeployError(f"there is no stack {stack}")
            made, stack_parameters = described.outputs, described.parameters
            s3, bucket = _client("s3", target), made["WebBucketName"]
            token = page_token.current_token(made, region, aws.settings(s3, bucket))
            if made["Canary"] == "on":
                page_token.give_canary(made, region, _client("ssm", target), stack)
            settings = public_settings(token, stack_parameters)
            contact = made.get("SecurityContact") or stack_parameters.get("OperatorContact")
            options = Options(made["SiteUrl"], contacts(stack_parameters))
            files = uploads(ROOT / "web", settings, contact, datetime.now(UTC), options)
            print(f"   {aws.upload(s3, bucket, files)} files")
        case "invalidate":
            made = _outputs(target)
            aws.invalidate(boto3.client("cloudfront"), made["DistributionId"], str(time.time_ns()))
        case "protect":
            aws.protect(_client("cloudformation", target), _client("dynamodb", target), stack)
        case "prune":
            clients = {name: _client(name, target) for name in ("cloudformation", "lambda", "s3")}
            versions, artifacts = prune(clients, stack, datetime.now(UTC))
            print(f"   {versions} versions, {artifacts} artifacts")
        case "smoke":
            if messages := list(_smoke(target, source)):
                advice = ["Return to the release before: make deploy ARGS=--back"] if target.exists else []
                raise DeployError("\n".join([*messages, *advice]))


def release(target: Target, source: Template) -> str:
    """Digest of what is deployed; raises KeyError if the address of the site is needed and not known."""
    stack = _describe(target)
    values = {**(stack.parameters if stack else {}), **target.effective}
    if stack and target.site is None and (url := stack.outputs.get("SiteUrl")):
        values["GuidanceUrl"] = f"{url}/calibrate/"
    return release_digest(source, values)


def _package(target: Target, source: Template) -> str:
    named = release(target, source)
    stack = _describe(target)
    tracing = {**(stack.parameters if stack else {}), **target.parameters}.get("Tracing")
    write_template(package_template(source, named, traced=tracing == "Active"), TEMPLATE)
    return named


def _smoke(target: Target, source: Template) -> Iterator[str]:
    region, stack = target.region, target.stack
    cloudformation, lambda_ = _client("cloudformation", target), _client("lambda", target)
    made = _outputs(target)
    site = smoke.Site(made["SiteUrl"], made["DistributionDomain"])
    yield from smoke.unreleased(aws.releases(cloudformation, lambda_, stack), release(target, source))
    yield from smoke.problems(smoke.make_requester(site.url, site.distribution), site)
    # Pages of other origins may use the API's own address, where the edge answers no preflights.
    at_api = smoke.make_requester(made["ApiUrl"].removesuffix("/v1"))
    yield from (f"{made['ApiUrl']}: {problem}" for problem in smoke.preflight_problems(at_api, "/v1/lookup"))
    settings = aws.settings(_client("s3", target), made["WebBucketName"])
    refit = aws.physical_id(cloudformation, stack, "RefitFunction")
    remove = functools.partial(smoke_capture.remove, made, region, refit)
    yield from smoke_capture.problems(site, settings.get("token", ""), remove)


def _fill_in(parameters: Mapping[str, str], target: Target) -> dict[str, str]:
    """Fill in the stack's outputs and the version of the edge's secret."""
    values: dict[str, str] = {}
    text = "".join(parameters.values())
    if "{SiteUrl}" in text:
        made = _outputs(target)
        values["{SiteUrl}"] = made["SiteUrl"]
    if "{EdgeSecretVersion}" in text:
        version = aws.edge_secret_version(_client("ssm", target), target.stack)
        values["{EdgeSecretVersion}"] = str(version)
    filled = dict(parameters)
    for place, value in values.items():
        filled = {name: content.replace(place, value) for name, content in filled.items()}
    return filled


def _different(parameters: Mapping[str, str], target: Target) -> list[str]:
    if not parameters:
        return []
    stack = _describe(target)
    values = stack.parameters if stack else {}
    return [name for name, value in parameters.items() if values.get(name) != value]


def _run(command: Sequence[str], target: Target) -> None:
    quiet = {**os.environ, "SAM_CLI_TELEMETRY": "0"}
    done = subprocess.run(command, cwd=ROOT, env=quiet, check=False)
    if done.returncode:
        said = f"{shlex.join(command)} failed"
        if command[1:2] == ["deploy"]:
            events = aws.failures(_client("cloudformation", target), target.stack)
            said = "\n".join([said, *account_check.explain(events)])
        raise DeployError(said)
