"""The environment that functions see: Lambda's variables and the template's, in the one there is."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from infra.deploy.intrinsics import REGION

# What would make boto3 look elsewhere than at the storage of this process: another endpoint, a developer's
# own profile.
_MISLEADING = (
    "AWS_ENDPOINT_URL",
    "AWS_ENDPOINT_URL_DYNAMODB",
    "AWS_ENDPOINT_URL_LAMBDA",
    "AWS_ENDPOINT_URL_S3",
    "AWS_PROFILE",
    "AWS_SESSION_TOKEN",
)
_EMBEDDED = {
    "AWS_ACCESS_KEY_ID": "local",
    "AWS_SECRET_ACCESS_KEY": "local",  # signs requests that never leave the process
    "AWS_CONFIG_FILE": os.devnull,
    "AWS_SHARED_CREDENTIALS_FILE": os.devnull,
    "AWS_EC2_METADATA_DISABLED": "true",
    "AWS_REGION": REGION,
    "AWS_DEFAULT_REGION": REGION,
}


def storage_is_elsewhere(environment: Mapping[str, str]) -> bool:
    """Tell whether the environment points at other storage than this process's own."""
    return environment.get("CALIBDB_STORAGE") == "aws" or "AWS_ENDPOINT_URL" in environment


@contextmanager
def set_variables(variables: Mapping[str, str], *, embedded: bool) -> Iterator[None]:
    """Set variables until the end of the block, and what keeps boto3 in this process if `embedded`."""
    wanted: dict[str, str | None] = dict(variables)
    if embedded:
        wanted = dict.fromkeys(_MISLEADING) | _EMBEDDED | wanted
    before = {name: os.environ.get(name) for name in wanted}
    _set(wanted)
    try:
        yield
    finally:
        _set(before)


def _set(variables: Mapping[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
