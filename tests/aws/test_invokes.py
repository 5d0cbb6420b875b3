"""Functions that call functions: at once, later, and again after a failure."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import boto3
import pytest
from botocore.exceptions import ClientError

from tests.aws.emulator import LocalStack
from tests.helpers.service.client import until
from tests.helpers.stack.toy_stack import deploy

#: appends every call to a file; fails as often as the event says, and asks others
RECORD = """
    import json, os, time
    from pathlib import Path
    def handler(event, context):
        with Path(os.environ["CALLS"]).open("a") as calls:
            calls.write(json.dumps([event, context.aws_request_id]) + "\\n")
        seen = Path(os.environ["CALLS"]).read_text().count(json.dumps(event))
        if seen <= event.get("fail", 0):
            raise ValueError("not yet")
        time.sleep(event.get("sleep", 0))
        while "after" in event and not Path(event["after"]).exists():
            time.sleep(0.005)
        return {"seen": seen, "tuple": (1, 2)}
"""

CALLER = """
    import boto3, json
    def handler(event, context):
        answer = boto3.client("lambda").invoke(FunctionName="Record", Payload=json.dumps({"from": "caller"}))
        return {"status": answer["StatusCode"], "answer": json.load(answer["Payload"])}
"""


@pytest.fixture
def template(tmp_path: Path) -> Path:
    return deploy(tmp_path, {"Record": (RECORD, ()), "Caller": (CALLER, ("GET /v1/call",))})


@pytest.fixture(autouse=True)
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[Any]]:
    path = tmp_path / "calls"
    path.touch()
    monkeypatch.setenv("CALLS", str(path))
    return lambda: [json.loads(line) for line in path.read_text().splitlines()]


def invoke(event: Any, kind: str = "RequestResponse", name: str = "Record") -> Any:
    return boto3.client("lambda").invoke(
        FunctionName=name, InvocationType=kind, Payload=json.dumps(event).encode()
    )


def test_a_call_is_answered_through_json(template: Path) -> None:
    with LocalStack(template=template):
        answer = invoke({"n": 1})
        assert answer["StatusCode"] == 200
        assert "FunctionError" not in answer
        assert json.load(answer["Payload"]) == {"seen": 1, "tuple": [1, 2]}
        by_arn = invoke({"n": 2}, name="arn:aws:lambda:us-east-1:123456789012:function:Record")
        assert by_arn["StatusCode"] == 200


def test_a_function_may_call_another_within_a_request(template: Path) -> None:
    with LocalStack(template=template) as stack:
        response = stack.request("GET", "/v1/call")
        assert response.json() == {"status": 200, "answer": {"seen": 1, "tuple": [1, 2]}}


def test_a_failure_is_the_functions(template: Path) -> None:
    with LocalStack(template=template):
        answer = invoke({"fail": 9})
        assert (answer["StatusCode"], answer["FunctionError"]) == (200, "Unhandled")
        assert json.load(answer["Payload"]) == {"errorMessage": "not yet", "errorType": "ValueError"}
        with pytest.raises(ClientError, match="ResourceNotFoundException"):
            invoke({}, name="Nobody")


def test_a_later_call_is_accepted_at_once_and_done_before_the_end(
    template: Path, tmp_path: Path, calls: Callable[[], list[Any]]
) -> None:
    accepted = tmp_path / "accepted"
    with LocalStack(template=template):
        for number in range(5):  # none of them comes to its end before all were accepted
            answer = invoke({"n": number, "after": str(accepted)}, "Event")
            assert (answer["StatusCode"], answer["Payload"].read()) == (202, b"")
        accepted.touch()
    assert sorted(event["n"] for event, _ in calls()) == [0, 1, 2, 3, 4]


def test_failed_event_is_retried_twice(template: Path, calls: Callable[[], list[Any]]) -> None:
    with LocalStack(template=template, retry_pauses=(0.0, 0.0)):
        invoke({"fail": 2}, "Event")
        until(lambda: len(calls()) == 3)
    assert len({request for _, request in calls()}) == 1, "a retry has the id of the call"
    assert len(calls()) == 3


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
        invoke({"fail": 99, "n": 7}, "Event")
        invoke({"n": 8}, "Event")
        stack.wait_until_idle(30)
        (record,) = stack.failures()
    assert record["requestPayload"] == {"fail": 99, "n": 7}
    assert record["responsePayload"] == {"errorMessage": "not yet", "errorType": "ValueError"}
    assert record["requestContext"]["condition"] == "RetriesExhausted"
    assert record["requestContext"]["approximateInvokeCount"] == 2
    assert len(calls()) == 3


def test_idle_stack_has_no_queued_running_or_retried_events(
    template: Path, tmp_path: Path, calls: Callable[[], list[Any]]
) -> None:
    gate = tmp_path / "gate"
    with LocalStack(template=template, retry_pauses=(0.0, 0.3)) as stack:
        stack.wait_until_idle(0)
        for number in range(4):  # two run, two are queued
            invoke({"n": number, "after": str(gate)}, "Event")
        with pytest.raises(TimeoutError, match="4 asynchronous calls unfinished"):
            stack.wait_until_idle(0.05)
        gate.touch()
        stack.wait_until_idle(30)
        assert sorted(event["n"] for event, _ in calls()) == [0, 1, 2, 3]
        invoke({"fail": 99}, "Event")
        stack.wait_until_idle(30)
        assert len(calls()) == 4 + 3


def test_one_stack_at_a_time(template: Path) -> None:
    with LocalStack(template=template):
        with pytest.raises(RuntimeError, match="running in this process already"):
            LocalStack(template=template).__enter__()
        assert invoke({"still": "there"})["StatusCode"] == 200
