"""AWS in memory, of which every test begins with an empty account."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import boto3
from moto import mock_aws


@cache
def session() -> boto3.Session:
    """Session that keeps the models of the services, a tenth of a second of JSON, for the next test."""
    return boto3.Session()


@contextmanager
def account() -> Iterator[None]:
    """Answer all requests of boto3 from memory."""
    with mock_aws():
        boto3.DEFAULT_SESSION = session()  # mock_aws takes it away again
        yield
