"""Lambda's part: functions, called by the gateway and by functions with what Lambda would hand them.

An asynchronous invocation runs once. Retries and the queue of failures are AWS's.
"""

import importlib
import json
import logging
import threading
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, urlsplit

from botocore.awsrequest import AWSPreparedRequest

from infra.server.jobs import Context
from tests.aws.emulator.storage import Answer
from tests.aws.emulator.template import FunctionSpec

_log = logging.getLogger("tests.aws.emulator.functions")


class FunctionError(Exception):
    """A handler could not be loaded, raised, or answered with what JSON cannot carry."""


@dataclass
class Function:
    """One function. On AWS an instance serves one call at a time; here one serves them all, in threads."""

    spec: FunctionSpec

    def __call__(self, event: Any) -> Any:
        """Invoke; event and answer pass through JSON, as they do between AWS's services.

        Raises FunctionError if the handler did not answer; the traceback is in the log.
        """
        context = Context(end=time.monotonic() + self.spec.timeout)
        try:
            handler = importlib.import_module(self.spec.module).handler
            return json.loads(json.dumps(handler(json.loads(json.dumps(event)), context)))
        except Exception as error:
            # Lambda's boundary: a handler may raise anything.
            _log.exception("%s failed (request %s)", self.spec.name, context.aws_request_id)
            raise FunctionError(f"{self.spec.name}: {type(error).__name__}: {error}") from error


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
