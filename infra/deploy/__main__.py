"""Deployment, its plan (`--plan`), or rotation of secrets: `python -m infra.deploy`.

AWS credentials are the operator's own, from the environment; a plan needs none.
"""

import argparse
import os
import shlex
import sys
from collections.abc import Sequence

from botocore.exceptions import BotoCoreError, ClientError

from calibdb.access.plans import multiplied
from calibdb.errors import UnavailableError
from calibdb.settings import Thresholds, parse_plan_factors
from infra.deploy.aws import DeployError
from infra.deploy.cutoff import switch
from infra.deploy.deployment import deploy
from infra.deploy.package import ROOT
from infra.deploy.site import uploads
from infra.deploy.steps import Target, steps
from infra.deploy.template import parse
from infra.release.checkout import CheckoutError, check_clean


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m infra.deploy")
    parser.add_argument("--stack", default=os.environ.get("STACK", "calibdb"))
    parser.add_argument("--region", default=os.environ.get("AWS_REGION", "us-east-1"))
    parser.add_argument("--plan", action="store_true", help="print the steps; needs no credentials")
    parser.add_argument("--rotate", action="store_true", help="only rotate the keys that sign session ids")
    parser.add_argument(
        "--rotate-edge", action="store_true", help="only rotate the secret that CloudFront sends"
    )
    parser.add_argument(
        "--back", action="store_true", help="only point all aliases at the version before their own"
    )
    parser.add_argument("--stop", action="store_true", help="only disable the distribution")
    parser.add_argument("--resume", action="store_true", help="only enable the distribution again")
    parser.add_argument(
        "--dirty", action="store_true", help="deploy although the checkout differs from its commit"
    )
    parser.add_argument("parameters", nargs="*", metavar="NAME=VALUE", help="of the template")
    options = parser.parse_args(arguments)
    pairs = [parameter.partition("=") for parameter in options.parameters]
    if not all(equals for _, equals, _ in pairs):
        parser.error("a parameter is written NAME=VALUE")
    parameters = {name: value for name, _, value in pairs}
    if unknown := sorted(parameters.keys() - parse(ROOT / "template.yaml")["Parameters"].keys()):
        parser.error(f"the template has no parameter {', '.join(unknown)}")
    try:
        Thresholds.from_environment({"THRESHOLDS": parameters.get("Thresholds", "")})
        multiplied(parse_plan_factors(parameters.get("PlanFactors", "")))
    except ValueError as error:
        parser.error(str(error))
    domain = parameters.get("DomainName")
    target = Target(options.stack, options.region, parameters, f"https://{domain}" if domain else None)
    if options.plan:
        print("\n".join(_plan(target)))
        return 0
    try:
        if options.back:
            _go_back(target)
        elif options.stop or options.resume:
            _switch(target, enabled=options.resume)
        elif options.rotate:
            target.account.rotate()
        elif options.rotate_edge:
            target.account.set_parameter("EdgeSecretVersion", str(target.account.rotate_edge()))
        else:
            if not options.dirty:
                check_clean()
            deploy(target)
    except CheckoutError as error:
        print(f"calibDB: {error}, or deploy with --dirty", file=sys.stderr)
        return 1
    except (DeployError, BotoCoreError, ClientError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1
    except UnavailableError as error:
        print(f"calibDB: {error.__cause__ or error}", file=sys.stderr)  # AWS names the call that it refused
        return 1
    return 0


def _go_back(target: Target) -> None:
    moved = target.account.step_back()
    if not moved:
        raise DeployError("no function has an earlier version")
    for function, (current, earlier) in moved.items():
        print(f"   {function}: version {current} -> {earlier}")
    print(
        "Not undone: the site's files, the template's other resources and parameters, RefitFunction and "
        "BackfillFunction, and stored data. Deploy a commit that works; it moves the aliases forward again."
    )


def _switch(target: Target, *, enabled: bool) -> None:
    account = target.account
    made = account.outputs()
    if "DistributionId" not in made:
        raise DeployError(f"there is no stack {target.stack} with a distribution")
    state = "enabled" if enabled else "disabled"
    changed = switch(account.client("cloudfront"), made["DistributionId"], enabled=enabled)
    print(f"The distribution is {'being ' if changed else ''}{state}{'' if changed else ' already'}.")
    if not enabled:
        print(f"{made['ApiUrl']} still responds: deploy with RequestRate=1 to stop it too.")


def _plan(target: Target) -> list[str]:
    lines = [f"{target.stack} in {target.region}"]
    for number, step in enumerate(steps(target), 1):
        lines.append(f"{number}. {step.text}")
        if step.command:
            lines.append(f"   {shlex.join(step.command)}")
        lines += [f"   {name}={shlex.quote(value)}" for name, value in sorted(step.parameters.items())]
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


if __name__ == "__main__":
    sys.exit(main())
