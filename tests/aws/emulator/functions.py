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


@dataclass
class Function:
    """One function. On AWS an instance serves one call at a time; here one serves them all, in threads."""

    spec: FunctionSpec

    def __call__(self, event: Any) -> Any:
        """Invoke; event and answer pass through JSON, as they do between AWS's services. Raises anything."""
        context = Context(end=time.monotonic() + self.spec.timeout)
        handler = importlib.import_module(self.spec.module).handler
        return json.loads(json.dumps(handler(json.loads(json.dumps(event)), context)))


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
        return _call(function, event)

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no asynchronous invocation is queued or running; raises TimeoutError."""
        with self._idle:
            if not self._idle.wait_for(lambda: self._unfinished == 0, seconds):
                raise TimeoutError(f"{self._unfinished} asynchronous calls unfinished after {seconds:g} s")

    def close(self) -> None:
        """Finish the queued invocations."""
        self._workers.shutdown()

    def _run(self, function: Function, event: Any) -> None:
        _call(function, event)
        with self._idle:
            self._unfinished -= 1
            self._idle.notify_all()


def _call(function: Function, event: Any) -> Answer:
    try:
        return Answer(200, {}, json.dumps(function(event)).encode())
    except Exception:  # noqa: BLE001 - a handler may raise anything
        _log.exception("%s failed", function.spec.name)
        return Answer(200, {"X-Amz-Function-Error": "Unhandled"}, b"{}")
