"""Deployment, its plan (`--plan`), or rotation of the session keys (`--rotate`): `python -m infra.deploy`.

AWS credentials are the operator's own, from the environment; a plan needs none.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import time
from collections.abc import Collection, Sequence

import boto3

from calibdb.settings import SettingsError, Thresholds
from infra.console.steps import announced
from infra.deploy import aws, smoke
from infra.deploy.site import uploads
from infra.deploy.steps import ROOT, TEMPLATE, Step, Target, package_template, steps
from infra.local.intrinsics import parse


class DeployError(RuntimeError):
    """The deployment ended before its end; the message says where."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m infra.deploy")
    parser.add_argument("--stack", default=os.environ.get("STACK", "calibdb"))
    parser.add_argument("--region", default=os.environ.get("AWS_REGION", "us-east-1"))
    parser.add_argument("--plan", action="store_true", help="print the steps; needs no credentials")
    parser.add_argument("--rotate", action="store_true", help="only rotate the keys that sign session ids")
    parser.add_argument("parameters", nargs="*", metavar="NAME=VALUE", help="of the template")
    asked = parser.parse_args(arguments)
    pairs = [parameter.partition("=") for parameter in asked.parameters]
    if not all(equals for _, equals, _ in pairs):
        parser.error("a parameter is written NAME=VALUE")
    parameters = {name: value for name, _, value in pairs}
    if unknown := sorted(parameters.keys() - parse(ROOT / "template.yaml")["Parameters"].keys()):
        parser.error(f"the template has no parameter {', '.join(unknown)}")
    try:
        Thresholds.from_environment({"THRESHOLDS": parameters.get("Thresholds", "")})
    except SettingsError as error:
        parser.error(str(error))
    domain = parameters.get("DomainName")
    target = Target(asked.stack, asked.region, parameters, f"https://{domain}" if domain else None)
    if asked.plan:
        print("\n".join(plan(target)))
        return 0
    try:
        if asked.rotate:
            aws.rotate(boto3.client("ssm", target.region), target.stack)
        else:
            deploy(target)
    except DeployError as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1
    return 0


def plan(target: Target) -> list[str]:
    """Describe the steps of `deploy`, line by line."""
    lines = [f"{target.stack} in {target.region}"]
    for number, step in enumerate(steps(target), 1):
        lines.append(f"{number}. {step.text}")
        if step.command:
            lines.append(f"   {shlex.join(step.command)}")
        if step.kind == "upload":
            files = list(uploads(ROOT / "web", {}))
            lines += [
                f"   {len(file.content):9,} {file.content_type:32} {file.content_encoding or '-':5} "
                f"{file.cache_control:58} {file.key}"
                for file in files
            ]
            size = sum(len(file.content) for file in files)
            lines.append(f"   {len(files)} files, {size / 1e6:.1f} MB")
    return lines


def deploy(target: Target, template: str | None = None, leave_out: Collection[str] = ()) -> None:
    """Do every step; raises DeployError at the first that fails.

    Parameters
    ----------
    target
        Where to.
    template
        Another one than `template.yaml`.
    leave_out
        Kinds of steps that are not done.
    """
    source = (ROOT / "template.yaml").read_text(encoding="utf-8") if template is None else template
    TEMPLATE.parent.mkdir(parents=True, exist_ok=True)
    TEMPLATE.write_text(package_template(source), encoding="utf-8")
    wanted = [step for step in steps(target) if step.kind not in leave_out]
    for step in announced(f"deploy {target.stack}", wanted, lambda step: step.text):
        _do(step, target)


def _do(step: Step, target: Target) -> None:
    region, stack = target.region, target.stack
    match step.kind:
        case "run":
            _run(_fill_in(step.command, target))
        case "secrets":
            aws.make_secrets(boto3.client("ssm", region), stack)
        case "upload":
            made = aws.outputs(boto3.client("cloudformation", region), stack)
            s3, bucket = boto3.client("s3", region), made["WebBucketName"]
            settings = aws.settings(s3, bucket) or {"api": "/v1", "token": _page_token(made, region)}
            print(f"   {aws.upload(s3, bucket, uploads(ROOT / 'web', settings))} files")
        case "invalidate":
            made = aws.outputs(boto3.client("cloudformation", region), stack)
            aws.invalidate(boto3.client("cloudfront"), made["DistributionId"], str(time.time_ns()))
        case "smoke":
            made = aws.outputs(boto3.client("cloudformation", region), stack)
            if found := list(smoke.problems(smoke.make_requester(made["SiteUrl"]))):
                raise DeployError("; ".join(found))


def _fill_in(command: tuple[str, ...], target: Target) -> list[str]:
    """Fill the stack's outputs into a command."""
    if not any("{SiteUrl}" in word for word in command):
        return list(command)
    made = aws.outputs(boto3.client("cloudformation", target.region), target.stack)
    return [word.replace("{SiteUrl}", made["SiteUrl"]) for word in command]


def _run(command: list[str]) -> None:
    quiet = {**os.environ, "SAM_CLI_TELEMETRY": "0"}
    done = subprocess.run(command, cwd=ROOT, env=quiet, check=False)  # noqa: S603 - our own steps
    if done.returncode:
        raise DeployError(f"{shlex.join(command)} failed")


def _page_token(made: dict[str, str], region: str) -> str:
    """Issue a token for the site's own pages."""
    command = [
        sys.executable,
        "-m",
        "infra.ops",
        "token",
        "create",
        "--plan",
        "page",
        "--origin",
        made["SiteUrl"],
    ]
    names = {"TABLE_NAME": made["TableName"], "BUCKET_NAME": made["KeypointBucketName"]}
    environment = {**os.environ, **names, "CALIBDB_STORAGE": "aws", "AWS_REGION": region}
    done = subprocess.run(  # noqa: S603 - our own command
        command, cwd=ROOT, env=environment, check=False, text=True, capture_output=True
    )
    token = next((word for word in done.stdout.split() if word.startswith("cdb_")), None)
    if token is None:
        raise DeployError(f"no token for the pages: {done.stderr.strip()}")
    return token


if __name__ == "__main__":
    sys.exit(main())
