"""Lambda's Invoke: synchronous and asynchronous invocations of functions by functions.

As on AWS, a failed asynchronous invocation is retried. If every attempt fails, it goes to the dead-letter
queue of the function.
"""

import json
import logging
import threading
import uuid
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import unquote, urlsplit

from botocore.awsrequest import AWSPreparedRequest

from tests.aws.emulator.functions import Function, FunctionError
from tests.aws.emulator.storage import Answer

_log = logging.getLogger("tests.aws.emulator.invokes")


class Invokes:
    """Delivers invocations to functions; `pauses`: s before the first retry and before the later ones."""

    def __init__(self, functions: Mapping[str, Function], pauses: Sequence[float]):
        self._functions = functions
        self._pauses = pauses
        self._closing = threading.Event()
        self._failures: list[dict[str, Any]] = []
        self._unfinished = 0
        self._idle = threading.Condition()
        self._workers = ThreadPoolExecutor(2, thread_name_prefix="invoke")

    def handle(self, operation: str, request: AWSPreparedRequest) -> Answer:
        """Respond to a request to "lambda" in the place of AWS."""
        if operation != "Invoke":
            return _error(501, "NotImplemented", f"the emulator does not implement {operation}")
        # /2015-03-31/functions/<name or ARN>/invocations
        name = unquote(urlsplit(request.url).path.split("/")[3]).rpartition(":")[2]
        if name not in self._functions:
            return _error(404, "ResourceNotFoundException", f"Function not found: {name}")
        body = request.body if isinstance(request.body, bytes) else b""
        try:
            event = json.loads(body or b"{}")
        except ValueError:
            return _error(400, "InvalidRequestContentException", "Could not parse request body into json")
        kind = request.headers.get("X-Amz-Invocation-Type", "RequestResponse")
        if kind in ("Event", b"Event"):
            with self._idle:
                self._unfinished += 1
            self._workers.submit(self._run, name, event)
            return Answer(202, {}, b"")
        return self._call(name, event)

    def failures(self) -> list[dict[str, Any]]:
        """Read the dead-letter queue: the invocations that failed every time, as Lambda records them."""
        return list(self._failures)

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no asynchronous invocation is queued, running, or waiting for a retry.

        Raises TimeoutError.
        """
        with self._idle:
            if not self._idle.wait_for(lambda: self._unfinished == 0, seconds):
                raise TimeoutError(f"{self._unfinished} asynchronous calls unfinished after {seconds:g} s")

    def close(self) -> None:
        """Finish the queued invocations, without further retries."""
        self._closing.set()
        self._workers.shutdown()

    def _call(self, name: str, event: Any) -> Answer:
        try:
            return Answer(200, {}, json.dumps(self._functions[name](event)).encode())
        except FunctionError as error:
            return Answer(200, {"X-Amz-Function-Error": "Unhandled"}, json.dumps(error.payload).encode())

    def _run(self, name: str, event: Any) -> None:
        try:
            self._deliver(self._functions[name], event, str(uuid.uuid4()))
        finally:
            with self._idle:
                self._unfinished -= 1
                self._idle.notify_all()

    def _deliver(self, function: Function, event: Any, request_id: str) -> None:
        attempts = 1 + function.spec.retries
        payload = {}
        for attempt in range(attempts):
            if attempt and self._closing.wait(self._pauses[min(attempt, len(self._pauses)) - 1]):
                return
            try:
                function(event, request_id)
                return
            except FunctionError as error:  # the function has logged it
                payload = error.payload
        _log.error("%s: a call failed %d times and is given up", function.spec.name, attempts)
        if function.spec.has_failures:
            # Source: AWS Lambda developer guide, "Capturing records of Lambda asynchronous invocations"
            self._failures.append({"requestPayload": event, "responsePayload": payload})


def _error(status: int, code: str, text: str) -> Answer:
    headers = {"content-type": "application/json", "x-amzn-ErrorType": code}
    return Answer(status, headers, json.dumps({"Type": "User", "message": text}).encode())
