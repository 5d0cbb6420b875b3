"""SAM's transform: the resources that CloudFormation would make of the template."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from infra.deploy import package

ROOT = Path(__file__).parents[2]


@cache
def complete() -> dict[str, Any]:
    """Template as packaged; callers must not change it."""
    return package.complete_template()


@cache
def resources() -> dict[str, Any]:
    """Resources of the complete template; callers must not change them."""
    found: dict[str, Any] = complete()["Resources"]
    return found


class ManagedPolicies:
    def load(self) -> dict[str, str]:
        return {
            "AWSLambdaBasicExecutionRole": "arn:aws:iam::aws:policy/service-role/AWSLambdaBasicExecutionRole"
        }


def as_created(source: dict[str, Any], parameters: dict[str, str] | None = None) -> dict[str, Any]:
    """Transform a template whose code and layers are in a bucket, as `sam package` leaves them."""
    from samtranslator.translator.transform import transform

    packaged = json.loads(json.dumps(source))
    for resource in packaged["Resources"].values():
        properties = resource.get("Properties", {})
        for place in ("CodeUri", "ContentUri", "DefinitionUri"):
            if place in properties:
                properties[place] = {"Bucket": "artifacts", "Key": f"{Path(str(properties[place])).name}.zip"}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_DEFAULT_REGION", "eu-central-1")
        created: dict[str, Any] = transform(packaged, parameters or {}, ManagedPolicies())
    return created


@cache
def created() -> dict[str, Any]:
    """Resources of the complete template after the transform; callers must not change them."""
    found: dict[str, Any] = as_created(complete(), {"Tracing": "Active"})["Resources"]
    return found


def without_events(source: dict[str, Any]) -> dict[str, Any]:
    """Template without events, which take nine tenths of the transform's time."""
    left: dict[str, Any] = json.loads(json.dumps(source))
    for resource in left["Resources"].values():
        resource.get("Properties", {}).pop("Events", None)
    return left


def versions(template: dict[str, Any]) -> dict[str, str]:
    return {
        resource["Properties"]["FunctionName"]["Ref"]: name
        for name, resource in template["Resources"].items()
        if resource["Type"] == "AWS::Lambda::Version"
    }
