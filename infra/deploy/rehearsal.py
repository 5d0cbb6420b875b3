"""Rehearsal of the deployment against ministack: `python -m infra.deploy.rehearsal`.

SAM's command line packs and uploads functions and layers, a stack is made of the template and changed, the
site is uploaded, the pages get their token, the keys are rotated. What ministack does not support, or only
AWS can answer, is left out and printed.
"""

import json
import os
import sys
from collections.abc import Iterator
from dataclasses import replace

from infra.ci import ministack
from infra.deploy import aws
from infra.deploy.aws import DeployError
from infra.deploy.deployment import deploy
from infra.deploy.package import ROOT, Template, complete_template
from infra.deploy.steps import Target

# Values that the SAM CLI would cut at a blank, or change; `deploy` compares them with the stack's.
_AWKWARD_VALUES = {"OperatorName": "Jane Doe", "Imprint": "Foo \"Ltd\"|12 High Street|'back' C:\\ \\"}
REHEARSAL = Target("rehearsal", "us-east-1", {"AlarmEmail": "operator@example.org", **_AWKWARD_VALUES})
# Of the template, what ministack cannot make: budgets, alarms on a sum, and what needs one of these.
UNSUPPORTED = (
    *("Budget", "ServerErrorAlarm", "TableThrottleAlarm", "EdgeBytesAlarm"),
    *("CutoffAlarm", "CutoffPermission"),
)
# The emulator does not deliver the site, and its functions run on AWS's processors.
_ONLY_ON_AWS = ("account", "smoke")
Versions = dict[str, tuple[str, str]]
"""Version and release of each alias, by the function's name."""
# A change only in a layer
_CHANGED = ROOT / ".build" / "layers" / "service" / "python" / "calibdb" / "rehearsed.py"


def main() -> int:
    """Deploy, change a layer, deploy nothing new, rotate; return 1 if the result is wrong."""
    with ministack.serving() as url:
        os.environ |= {
            "AWS_ENDPOINT_URL": url,
            "AWS_ACCESS_KEY_ID": "rehearsal",
            "AWS_SECRET_ACCESS_KEY": "rehearsal",
            "AWS_REGION": REHEARSAL.region,
            "AWS_DEFAULT_REGION": REHEARSAL.region,
        }
        os.environ.pop("AWS_PROFILE", None)
        template = remove_unsupported(complete_template())
        try:
            deploy(REHEARSAL, template, _ONLY_ON_AWS)
            settings, first = _settings(), _live()
            _CHANGED.write_text("# another line\n", encoding="utf-8")
            # The address is emptied again.
            silent = replace(REHEARSAL, parameters={**_AWKWARD_VALUES, "AlarmEmail": ""})
            deploy(silent, template, (*_ONLY_ON_AWS, "build"))
            second = _live()
            deploy(silent, template, (*_ONLY_ON_AWS, "build"))
            third = _live()
            REHEARSAL.account.rotate()
            REHEARSAL.account.rotate_edge()
        except DeployError as error:
            print(f"calibDB: {error}", file=sys.stderr)
            return 1
        finally:
            _CHANGED.unlink(missing_ok=True)
        messages = [*_problems(), *_find_unpublished(first, second, third)]
        if _settings() != settings:
            messages.append("the second deployment gave the pages another token")
    print(f"left out: {', '.join((*UNSUPPORTED, *_ONLY_ON_AWS))}")
    for problem in messages:
        print(f"calibDB: {problem}", file=sys.stderr)
    return 1 if messages else 0


def _live() -> Versions:
    account = REHEARSAL.account
    versions, lambda_ = {}, account.client("lambda")
    for name, release in account.releases().items():
        try:
            version = lambda_.get_alias(FunctionName=name, Name="live")["FunctionVersion"]
        except lambda_.exceptions.ResourceNotFoundException:
            version = "$LATEST"
        versions[name] = version, release
    return versions


def _find_unpublished(first: Versions, second: Versions, third: Versions) -> Iterator[str]:
    """Find functions that a change in a layer did not reach, or that were published without a change."""
    for name, (_, release) in second.items():
        if release == first[name][1]:
            yield f"{name}: the alias kept the release {release} when a layer changed"
        if third[name] != second[name]:
            yield f"{name}: an equal build published {third[name]}"
    print(
        f"{len(second)} functions at release {', '.join(sorted({release for _, release in second.values()}))}"
    )


def remove_unsupported(template: Template) -> Template:
    """Remove what ministack does not support: resources, and deployments by CodeDeploy."""
    resources = template["Resources"]
    for name in UNSUPPORTED:
        del resources[name]
    for owner in (template["Globals"]["Function"], *(each["Properties"] for each in resources.values())):
        owner.pop("DeploymentPreference", None)
    # The linter refuses a condition that no resource has any more.
    text = json.dumps(template)
    for name in list(template["Conditions"]):
        if text.count(f'"{name}"') == 1:
            del template["Conditions"][name]
    return template


def _problems() -> Iterator[str]:
    """Find the differences between the template and the deployed resources."""
    account = REHEARSAL.account
    stack = account.describe()
    if stack.status != "UPDATE_COMPLETE":
        yield f"the stack is {stack.status}"
    made, guidance = stack.outputs, stack.parameters["GuidanceUrl"]
    if guidance != f"{made['SiteUrl']}/calibrate/":
        yield f"lookups are sent to {guidance}"
    ssm, path = account.client("ssm"), f"/calibdb/{REHEARSAL.stack}"
    secrets = ssm.get_parameters_by_path(Path=path, WithDecryption=True)
    keys = {p["Name"].rpartition("/")[2]: p["Value"].count(",") + 1 for p in secrets["Parameters"]}
    if keys != {"SESSION_SECRETS": 3, "CONTRIBUTOR_SECRET": 1, "EDGE_SECRETS": 3, "EDGE_SECRET": 1}:
        yield f"the secrets hold so many keys: {keys}"
    page = account.client("s3").head_object(Bucket=made["WebBucketName"], Key="calibrate/index.html")
    if page["ContentType"] != "text/html; charset=utf-8":
        yield f"a page is {page['ContentType']}"
    print(f"{len(account.resources())} resources, {len(made)} outputs")


def _settings() -> dict[str, str]:
    account = REHEARSAL.account
    return dict(aws.settings(account.client("s3"), account.outputs()["WebBucketName"]))


if __name__ == "__main__":
    sys.exit(main())
