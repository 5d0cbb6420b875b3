"""A release has a name of its own, which every function carries, so that a new one reaches the aliases."""

import json
import shutil
from pathlib import Path

import pytest

from infra.deploy import package
from tests.helpers.sam import ROOT, as_created, complete, created, versions, without_events
from tests.helpers.service.iam import statements

API = {
    f"{name}Function"
    for name in (
        *("Auth", "Session", "NextPose", "Submit", "Rig"),
        *("Lookup", "Export", "Checks", "Cameras", "Tokens"),
    )
}


@pytest.fixture
def code(tmp_path: Path) -> tuple[Path, ...]:
    """Two layers and the functions, as a build leaves them."""
    for layer in ("service/calibdb", "solver/calibsolver"):
        source = ROOT / "layers" / layer
        shutil.copytree(source, tmp_path / "layers" / layer, ignore=shutil.ignore_patterns("__pycache__"))
    ignored = shutil.ignore_patterns("__pycache__")
    return tmp_path / "layers", shutil.copytree(ROOT / "functions", tmp_path / "functions", ignore=ignored)


def digest(code: tuple[Path, ...], **parameters: str) -> str:
    return package.release_digest(complete(), parameters, code)


def edit(path: Path) -> None:
    path.write_text(path.read_text() + "\n# another line\n")


def test_one_line_of_the_code_is_another_release(code: tuple[Path, ...]) -> None:
    digests = {digest(code)}
    assert digests == {digest(code)}  # an equal build is not one
    layers, functions = code
    edited = ("service/calibdb/settings.py", "solver/calibsolver/rotation.py")
    for file in (*(layers / name for name in edited), functions / "lookup/app.py"):
        edit(file)
        assert digest(code) not in digests, file
        digests.add(digest(code))


def test_a_parameter_that_functions_use_is_another_release(code: tuple[Path, ...]) -> None:
    used = (
        {"GuidanceUrl": "https://site.example/calibrate/"},
        {"Thresholds": "MIN_VOTES=5"},
        {"SnapStart": "PublishedVersions"},
        {"Tracing": "Active"},
    )
    assert len({digest(code), *(digest(code, **one) for one in used)}) == 1 + len(used)
    unused = {"AlarmEmail": "a@example.org", "MonthlyBudget": "70", "Rollout": "AllAtOnce"}
    assert digest(code, **unused) == digest(code)


def test_compiled_leftovers_of_functions_are_no_release(code: tuple[Path, ...]) -> None:
    before = digest(code)
    (code[1] / "lookup/__pycache__").mkdir()
    (code[1] / "lookup/__pycache__/app.cpython-311.pyc").write_bytes(b"x")
    assert digest(code) == before
    (code[0] / "service/__pycache__").mkdir()  # compiled modules of a layer are uploaded
    (code[0] / "service/__pycache__/x.cpython-313.pyc").write_bytes(b"x")
    assert digest(code) != before


def test_every_function_carries_its_release_and_another_one_publishes_its_version() -> None:
    before, after = (
        as_created(without_events(package.package_template(complete(), release)))
        for release in ("0" * 16, "1" * 16)
    )
    functions = [
        resource["Properties"]
        for name, resource in before["Resources"].items()
        if resource["Type"] == "AWS::Lambda::Function"
        and name not in ("Probe", "CutoffFunction")  # their code is inline
    ]
    internal = {"Refit", "Backfill", "Verify", "Dump", "Health", "Canary"}
    assert len(functions) == len(API) + len(internal)
    assert {f["Environment"]["Variables"]["RELEASE"] for f in functions} == {"0" * 16}
    assert set(versions(before)) == API
    assert {name for name in API if versions(after)[name] != versions(before)[name]} == API


def test_calls_move_to_a_release_gradually_and_back_on_an_alarm() -> None:
    resources = created()
    aliases = {n: r for n, r in resources.items() if r["Type"] == "AWS::Lambda::Alias"}
    assert {alias["Properties"]["FunctionName"]["Ref"] for alias in aliases.values()} == API
    assert all("CodeDeployLambdaAliasUpdate" in alias["UpdatePolicy"] for alias in aliases.values())
    groups = [r["Properties"] for r in resources.values() if r["Type"] == "AWS::CodeDeploy::DeploymentGroup"]
    assert len(groups) == len(API)
    for group in groups:
        names = [alarm["Name"]["Ref"] for alarm in group["AlarmConfiguration"]["Alarms"]]
        assert group["AlarmConfiguration"]["Enabled"]
        assert names == ["ReleaseAlarm", "ReleaseResponseAlarm"]
        assert "Canary10Percent5Minutes" in json.dumps(group["DeploymentConfigName"])
        assert "DEPLOYMENT_STOP_ON_ALARM" in group["AutoRollbackConfiguration"]["Events"]
    # The API's routes lead to the aliases, which wait for the alarm: it may not name the API.
    for name in names:
        assert "HttpApi" not in json.dumps(resources[name]["Properties"])


def test_roles_may_write_traces_only_if_requests_are_traced() -> None:
    def policies(*, traced: bool) -> set[str]:
        document = without_events(package.package_template(complete(), traced=traced))
        roles = [r for r in as_created(document)["Resources"].values() if r["Type"] == "AWS::IAM::Role"]
        return {str(arn) for role in roles for arn in role["Properties"].get("ManagedPolicyArns", [])}

    assert not [arn for arn in policies(traced=False) if "Xray" in arn or "XRay" in arn]
    assert [arn for arn in policies(traced=True) if "Xray" in arn or "XRay" in arn]


def test_functions_that_read_sessions_may_list_them() -> None:
    """Else S3 says 403 of a session that another request has just deleted, which would be a fault of ours."""
    source = complete()
    for name, resource in source["Resources"].items():
        if resource["Type"] != "AWS::Serverless::Function":
            continue
        granted = list(statements(source, resource["Properties"]))
        reads = [
            s for s in granted if "s3:GetObject" in s["Action"] and "/sessions/*" in json.dumps(s["Resource"])
        ]
        lists = [s for s in granted if "s3:ListBucket" in s["Action"]]
        prefixes = {prefix for s in lists for prefix in s["Condition"]["StringLike"]["s3:prefix"]}
        assert not reads or "sessions/*" in prefixes, name
