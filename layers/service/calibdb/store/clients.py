"""AWS clients, made when first used and then kept: a connection costs more than most requests.

They are botocore's, which boto3's are too; boto3 itself would add S3's transfer manager, a fifth of what a
lookup imports, for which nothing here has a use.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, cast

import botocore.session
from botocore.config import Config
from botocore.exceptions import BotoCoreError, ClientError

from calibdb.errors import UnavailableError

if TYPE_CHECKING:
    from mypy_boto3_dynamodb import DynamoDBClient
    from mypy_boto3_lambda import LambdaClient
    from mypy_boto3_s3 import S3Client

# Storage answers in milliseconds or not at all; the gateway gives up after 30 s, the function after 29.
_STORAGE = Config(
    connect_timeout=1,
    read_timeout=2,
    retries={"mode": "standard", "total_max_attempts": 3},
    tcp_keepalive=True,
)
# Who reads the secrets tries again by itself, with pauses that spread a crowd.
_SECRETS = Config(connect_timeout=1, read_timeout=2, retries={"mode": "standard", "total_max_attempts": 1})
# A computation is asked for once: repeating it because it is slow would make it slower.
_INVOKE = Config(connect_timeout=1, read_timeout=25, retries={"mode": "standard", "total_max_attempts": 1})


class ParameterReader(Protocol):
    """Part of SSM's client that reads parameters."""

    def get_parameters(self, *, Names: Sequence[str], WithDecryption: bool) -> Mapping[str, Any]:  # noqa: N803
        """Return the parameters of these names, ten at most."""
        ...


_making = threading.Lock()  # a session is not safe to make clients with in several threads


@functools.cache
def dynamodb(region: str) -> DynamoDBClient:
    """Return the client of the index."""
    return cast("DynamoDBClient", _make("dynamodb", region, _STORAGE))


@functools.cache
def s3(region: str) -> S3Client:
    """Return the client of the bucket."""
    return cast("S3Client", _make("s3", region, _STORAGE))


@functools.cache
def lambda_(region: str) -> LambdaClient:
    """Return the client that asks other functions."""
    return cast("LambdaClient", _make("lambda", region, _INVOKE))


@functools.cache
def ssm(region: str) -> ParameterReader:
    """Return the client of the parameter store."""
    return cast("ParameterReader", _make("ssm", region, _SECRETS))


@functools.cache
def _session() -> botocore.session.Session:
    return botocore.session.get_session()


def _make(service: str, region: str, config: Config) -> object:
    with _making:
        return _session().create_client(service, region_name=region, config=config)


def code(error: ClientError) -> str:
    """Return AWS's name of an error."""
    return error.response["Error"]["Code"]


@contextmanager
def available() -> Iterator[None]:
    """Turn what storage could not do, after its retries, into UnavailableError: the caller may try again."""
    try:
        yield
    except (ClientError, BotoCoreError) as error:
        name = code(error) if isinstance(error, ClientError) else type(error).__name__
        raise UnavailableError(f"Storage did not answer ({name}).") from error
