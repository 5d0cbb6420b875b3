"""The emulator's asynchronous calls, repeated after a failure, and its place in the environment."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import boto3
import pytest

from tests.aws.emulator import LocalStack
from tests.helpers.stack.toy_stack import deploy

#: appends every call to a file; fails as often as the event says
RECORD = """
    import json, os, time
    from pathlib import Path
    def handler(event, context):
        with Path(os.environ["CALLS"]).open("a") as calls:
            calls.write(json.dumps([event, context.aws_request_id]) + "\\n")
        seen = Path(os.environ["CALLS"]).read_text().count(json.dumps(event))
        if seen <= event.get("fail", 0):
            raise ValueError("not yet")
        while "after" in event and not Path(event["after"]).exists():
            time.sleep(0.005)
        return seen
"""


@pytest.fixture
def template(tmp_path: Path) -> Path:
    return deploy(tmp_path, {"Record": (RECORD, ())})


@pytest.fixture(autouse=True)
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[Any]]:
    path = tmp_path / "calls"
    path.touch()
    monkeypatch.setenv("CALLS", str(path))
    return lambda: [json.loads(line) for line in path.read_text().splitlines()]


def invoke_later(event: Any) -> None:
    answer = boto3.client("lambda").invoke(
        FunctionName="Record", InvocationType="Event", Payload=json.dumps(event).encode()
    )
    assert (answer["StatusCode"], answer["Payload"].read()) == (202, b"")


def test_given_up_event_is_in_the_dead_letter_queue(template: Path, calls: Callable[[], list[Any]]) -> None:
    queue = """
      EventInvokeConfig:
        MaximumRetryAttempts: 1
        DestinationConfig: {OnFailure: {Type: SQS, Destination: !GetAtt Failed.Arn}}
  Failed:
    Type: AWS::SQS::Queue
"""
    code = "      CodeUri: functions/Record/"
    template.write_text(template.read_text().replace(code, code + queue.rstrip()))
    with LocalStack(template=template, retry_pauses=(0.0,)) as stack:
        invoke_later({"fail": 99, "n": 7})
        invoke_later({"n": 8})
        stack.wait_until_idle(30)
        (record,) = stack.failures()
    assert record["requestPayload"] == {"fail": 99, "n": 7}
    assert record["responsePayload"] == {"errorMessage": "not yet", "errorType": "ValueError"}
    assert record["requestContext"]["condition"] == "RetriesExhausted"
    assert record["requestContext"]["approximateInvokeCount"] == 2
    failed = [request for event, request in calls() if event["n"] == 7]
    assert len(failed) == 2
    assert len(set(failed)) == 1, "a retry has the id of the call"


def test_idle_stack_has_no_queued_running_or_retried_events(
    template: Path, tmp_path: Path, calls: Callable[[], list[Any]]
) -> None:
    gate = tmp_path / "gate"
    with LocalStack(template=template, retry_pauses=(0.0, 0.3)) as stack:
        stack.wait_until_idle(0)
        for number in range(4):  # two run, two are queued
            invoke_later({"n": number, "after": str(gate)})
        with pytest.raises(TimeoutError, match="4 asynchronous calls unfinished"):
            stack.wait_until_idle(0.05)
        gate.touch()
        stack.wait_until_idle(30)
        assert sorted(event["n"] for event, _ in calls()) == [0, 1, 2, 3]
        invoke_later({"fail": 99})
        stack.wait_until_idle(30)
        assert len(calls()) == 4 + 3


def test_a_developers_own_aws_settings_do_not_matter(template: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_PROFILE", "no-such-profile")
    monkeypatch.setenv("AWS_ENDPOINT_URL_S3", "http://127.0.0.1:1")
    monkeypatch.setenv("AWS_SESSION_TOKEN", "expired")
    monkeypatch.setenv("AWS_REGION", "eu-central-1")
    before = dict(os.environ)
    with LocalStack(template=template):
        assert boto3.client("s3").list_objects_v2(Bucket="calibdb-files")["KeyCount"] == 0
    assert dict(os.environ) == before
