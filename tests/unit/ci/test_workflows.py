"""Workflows of GitHub Actions: what they may do, and that what they call exists."""

import re
from typing import Any

import pytest
import yaml

from tests.helpers.data import ROOT

FOLDER = ROOT / ".github" / "workflows"


def read(name: str) -> dict[str, Any]:
    # In YAML 1.1 the key `on` is a truth value.
    return yaml.safe_load((FOLDER / name).read_text().replace("\non:", '\n"on":'))


@pytest.mark.parametrize("name", [path.name for path in sorted(FOLDER.glob("*.yml"))])
def test_workflow_calls_targets_that_exist_with_least_permissions(name: str) -> None:
    workflow = read(name)
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    steps = [step for job in workflow["jobs"].values() for step in job["steps"]]
    called = {
        word
        for step in steps
        for command in re.findall(r"^make ([a-z ]+)", step.get("run", ""), re.MULTILINE)
        for word in command.split()
    }
    assert called
    assert called <= targets
    access = {scope: level for scope, level in workflow["permissions"].items() if scope != "id-token"}
    assert "write" not in access.values() or name == "release.yml"
    assert all(job["timeout-minutes"] <= 60 for job in workflow["jobs"].values())
    # What a person types is read from the environment: as part of a command, it would be one.
    assert not [step for step in steps if re.search(r"\$\{\{\s*(inputs|github\.event)", step.get("run", ""))]


def test_tests_run_on_both_processors_and_import_the_built_layers() -> None:
    jobs = read("test.yml")["jobs"]
    assert {job["runs-on"] for job in jobs.values()} == {"ubuntu-24.04", "ubuntu-24.04-arm"}
    arm = [step.get("run", "") for step in jobs["arm64"]["steps"]]
    built = arm.index("make layers")
    imported = next(i for i, run in enumerate(arm) if "infra/ci/import_handlers.py" in run)
    assert built < imported
    assert "public.ecr.aws/lambda/python:3.13-arm64" in arm[imported]


def test_deployment_is_of_a_checked_tag_and_by_openid_connect() -> None:
    workflow = read("deploy.yml")
    assert set(workflow["on"]) == {"workflow_dispatch"}
    assert workflow["permissions"] == {"contents": "read", "id-token": "write"}
    (job,) = workflow["jobs"].values()
    assert job["if"] == "startsWith(github.ref, 'refs/tags/v')"
    assert job["environment"] == "production"
    steps = job["steps"]
    order = [step.get("run", step.get("uses", "")) for step in steps]
    checked = next(i for i, text in enumerate(order) if text.startswith("make release"))
    assumed = next(i for i, text in enumerate(order) if text.startswith("aws-actions/configure-aws"))
    deployed = next(i for i, text in enumerate(order) if text.startswith("make deploy"))
    assert checked < assumed < deployed
    assert "role-to-assume" in steps[assumed]["with"]
    assert "aws-secret-access-key" not in steps[assumed]["with"]


def test_release_publishes_what_was_built_of_the_tag() -> None:
    (job,) = read("release.yml")["jobs"].values()
    runs = [step.get("run", "") for step in job["steps"]]
    assert any(run.startswith('make release ARGS="build --tag $GITHUB_REF_NAME"') for run in runs)
    assert ".build/release/*" in runs[-1]


def test_dependabot_watches_every_kind_of_dependency() -> None:
    updates = yaml.safe_load((ROOT / ".github/dependabot.yml").read_text())["updates"]
    assert {update["package-ecosystem"] for update in updates} == {"github-actions", "npm", "pip"}
