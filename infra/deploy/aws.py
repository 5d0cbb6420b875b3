"""Calls of a deployment to AWS's API. All of them are idempotent."""

from __future__ import annotations

import json
import secrets
from collections.abc import Iterable, Mapping
from typing import Any

from infra.deploy.site import Upload

SECRETS = ("SESSION_SECRETS", "CONTRIBUTOR_SECRET", "EDGE_SECRET")
# CloudFormation reads this one for CloudFront's header, and of secure ones it can read none there.
_READ_BY_CLOUDFORMATION = ("EDGE_SECRET",)
_MAX_SESSION_KEYS = 3  # of SESSION_SECRETS: the one that signs, the next, the one before


def missing_secrets(ssm: Any, stack: str) -> list[str]:
    """List the secrets that the stack does not have yet."""
    found = ssm.get_parameters(Names=[f"/calibdb/{stack}/{name}" for name in SECRETS])
    there = {p["Name"].rpartition("/")[2] for p in found["Parameters"]}
    return [name for name in SECRETS if name not in there]


def make_secrets(ssm: Any, stack: str) -> list[str]:
    """Make the secrets that are missing, never another over one that is there; return their names."""
    missing = missing_secrets(ssm, stack)
    for name in missing:
        keys = 2 if name == "SESSION_SECRETS" else 1  # the one that signs, and the next
        ssm.put_parameter(
            Name=f"/calibdb/{stack}/{name}",
            Value=",".join(secrets.token_hex(32) for _ in range(keys)),
            Type="String" if name in _READ_BY_CLOUDFORMATION else "SecureString",
            Overwrite=False,
        )
    return missing


def rotate(ssm: Any, stack: str) -> None:
    """Let the next key sign, keep the one before, add a new next one.

    Every function knew the next key before it signs: while they learn of the rotation, within five minutes,
    none refuses what another has signed.
    """
    name = f"/calibdb/{stack}/SESSION_SECRETS"
    kept = ssm.get_parameter(Name=name, WithDecryption=True)["Parameter"]["Value"].split(",")
    value = ",".join(rotate_keys(kept, secrets.token_hex(32)))
    ssm.put_parameter(Name=name, Value=value, Type="SecureString", Overwrite=True)


def rotate_keys(keys: list[str], new: str) -> list[str]:
    """Rotate the keys: of `current, next, before` it makes `next, new, current`."""
    current, following = keys[0], keys[1] if len(keys) > 1 else None
    return ([following, new, current] if following else [current, new])[:_MAX_SESSION_KEYS]


def outputs(cloudformation: Any, stack: str) -> dict[str, str]:
    """Read the stack's outputs by name."""
    (found,) = cloudformation.describe_stacks(StackName=stack)["Stacks"]
    return {output["OutputKey"]: output["OutputValue"] for output in found.get("Outputs", ())}


def upload(s3: Any, bucket: str, files: Iterable[Upload]) -> int:
    """Upload the files in their order; return how many."""
    number = 0
    for number, file in enumerate(files, 1):  # noqa: B007 - how many there were
        encoding = {"ContentEncoding": file.content_encoding} if file.content_encoding else {}
        s3.put_object(
            Bucket=bucket,
            Key=file.key,
            Body=file.content,
            ContentType=file.content_type,
            CacheControl=file.cache_control,
            **encoding,
        )
    return number


def settings(s3: Any, bucket: str) -> Mapping[str, str] | None:
    """Read the deployed `/config.json`, None where there is none."""
    listed = s3.list_objects_v2(Bucket=bucket, Prefix="config.json", MaxKeys=1)
    if not listed.get("KeyCount"):
        return None
    found: Mapping[str, str] = json.loads(s3.get_object(Bucket=bucket, Key="config.json")["Body"].read())
    return found


def invalidate(cloudfront: Any, distribution: str, caller: str) -> None:
    """Have the edge forget everything; `caller` is another one for every time."""
    cloudfront.create_invalidation(
        DistributionId=distribution,
        InvalidationBatch={"Paths": {"Quantity": 1, "Items": ["/*"]}, "CallerReference": caller},
    )
