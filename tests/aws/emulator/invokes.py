"""Lambda's Invoke: synchronous and asynchronous invocations of functions by functions.

An asynchronous invocation runs once. Retries and the queue of failures are AWS's.
"""

import json
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import unquote, urlsplit

from botocore.awsrequest import AWSPreparedRequest

from tests.aws.emulator.functions import Function, FunctionError
from tests.aws.emulator.storage import Answer


class Invokes:
    """Delivers invocations to functions."""

    def __init__(self, functions: Mapping[str, Function]):
        self._functions = functions
        self._unfinished = 0
        self._idle = threading.Condition()
        self._workers = ThreadPoolExecutor(2, thread_name_prefix="invoke")

    def handle(self, _: str, request: AWSPreparedRequest) -> Answer:
        """Respond to an invocation in the place of AWS."""
        # /2015-03-31/functions/<name or ARN>/invocations
        name = unquote(urlsplit(request.url).path.split("/")[3]).rpartition(":")[2]
        function, event = self._functions[name], json.loads(request.body)
        if request.headers.get("X-Amz-Invocation-Type") in ("Event", b"Event"):
            with self._idle:
                self._unfinished += 1
            self._workers.submit(self._run, function, event)
            return Answer(202, {}, b"")
        try:
            return Answer(200, {}, json.dumps(function(event)).encode())
        except FunctionError as error:
            return Answer(200, {"X-Amz-Function-Error": "Unhandled"}, json.dumps(str(error)).encode())

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no asynchronous invocation is queued or running; raises TimeoutError."""
        with self._idle:
            if not self._idle.wait_for(lambda: self._unfinished == 0, seconds):
                raise TimeoutError(f"{self._unfinished} asynchronous calls unfinished after {seconds:g} s")

    def close(self) -> None:
        """Finish the queued invocations."""
        self._workers.shutdown()

    def _run(self, function: Function, event: Any) -> None:
        try:
            function(event)
        finally:  # the function has logged its failure
            with self._idle:
                self._unfinished -= 1
                self._idle.notify_all()
