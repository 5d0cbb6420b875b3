"""AWS in memory, of which every test begins with an empty account."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

import boto3
from moto import mock_aws
from moto.core.botocore_stubber import BotocoreStubber


@cache
def session() -> boto3.Session:
    """Session that keeps the models of the services, a tenth of a second of JSON, for the next test."""
    return boto3.Session()


@contextmanager
def account() -> Iterator[None]:
    """Answer all requests of boto3 from memory, one at a time: a write of moto is not atomic."""
    one_at_a_time, answer = threading.RLock(), BotocoreStubber.__call__

    def answer_alone(*arguments: Any, **named: Any) -> Any:
        with one_at_a_time:
            return answer(*arguments, **named)

    with mock_aws(), patch.object(BotocoreStubber, "__call__", answer_alone):
        boto3.DEFAULT_SESSION = session()  # mock_aws takes it away again
        yield
