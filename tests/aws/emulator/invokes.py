"""Lambda's Invoke: synchronous and asynchronous invocations of functions by functions.

Asynchronous invocations are durable and delivered at least once, as on AWS: an invocation is journalled
before the caller is answered, retried when it fails, delivered again after a restart, and removed once it
succeeded. So a function must be idempotent. An invocation that failed every time goes to the dead-letter
queue that the template names for the function; it is kept in the journal.
"""

from __future__ import annotations

import json
import logging
import threading
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from datetime import UTC, datetime
from typing import Any
from urllib.parse import unquote, urlsplit

from botocore.awsrequest import AWSPreparedRequest

from infra.deploy.intrinsics import ACCOUNT, REGION
from tests.aws.emulator.functions import Function, FunctionError
from tests.aws.emulator.journal import Address, Change, Content
from tests.aws.emulator.storage import Answer, NotDurableError, Storage
from tests.aws.emulator.template import FunctionSpec

INVOKE = "invoke"
FAILURE = "failure"
SHUTDOWN_GRACE_S = 5.0

_log = logging.getLogger("tests.aws.emulator.invokes")


class Invokes:
    """Delivers calls to functions.

    Parameters
    ----------
    functions
        By name.
    outbox
        Where accepted asynchronous calls survive; None: nowhere.
    lasting
        Whether the outbox outlives the process.
    pauses
        Seconds before the first retry and before the later ones. Lambda waits one and two minutes; who tries
        something out on their own machine need not.
    shutdown_grace_s
        Seconds for which waiting calls still get their turn once the stack is told to stop.
    executor
        Runs asynchronous calls; two threads unless told otherwise.
    """

    def __init__(
        self,
        functions: Mapping[str, Function],
        outbox: Storage | None,
        lasting: bool,
        pauses: Sequence[float],
        clock: Callable[[], float] = time.time,
        shutdown_grace_s: float = SHUTDOWN_GRACE_S,
        executor: Executor | None = None,
    ):
        self._functions = functions
        self._outbox = outbox
        self._lasting = lasting
        self._pauses = pauses
        self._clock = clock
        self._shutdown_grace_s = shutdown_grace_s
        self._deadline = 0.0
        self._closing = threading.Event()
        self._unfinished = 0
        self._idle = threading.Condition()
        # Two at once: more would only take the processor from the requests that someone waits for.
        self._workers = executor or ThreadPoolExecutor(2, thread_name_prefix="invoke")

    def handle(self, operation: str, request: AWSPreparedRequest) -> Answer:
        """Answer a request to "lambda" in the place of AWS."""
        if operation != "Invoke":
            return _error(501, "NotImplemented", f"the local stack does not know {operation}")
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
        if isinstance(kind, bytes):
            kind = kind.decode()
        if kind == "Event":
            return self._accept(name, event)
        return self._call(name, event)

    def redeliver_pending(self) -> int:
        """Deliver the pending invocations of before a restart; return their number."""
        pending = self._outbox.persisted(INVOKE) if self._outbox else []
        for change in pending:
            if change.content and change.address.container in self._functions:
                self._submit(change.address, json.loads(change.content.body))
        return len(pending)

    def failures(self) -> list[dict[str, Any]]:
        """Read the dead-letter queue: the invocations that failed every time, as Lambda records them."""
        kept = self._outbox.persisted(FAILURE) if self._outbox else []
        return [json.loads(change.content.body) for change in kept if change.content]

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no asynchronous call is queued, running, or waiting for a retry.

        Raises
        ------
        TimeoutError
            If calls are still unfinished after `seconds`.
        """
        with self._idle:
            if not self._idle.wait_for(lambda: self._unfinished == 0, seconds):
                raise TimeoutError(f"{self._unfinished} asynchronous calls unfinished after {seconds:g} s")

    def close(self) -> None:
        """Finish what is under way or has its turn soon; the rest, and retries, wait for the next start."""
        self._deadline = time.monotonic() + self._shutdown_grace_s
        self._closing.set()
        self._workers.shutdown()

    def _call(self, name: str, event: Any) -> Answer:
        try:
            return Answer(200, {}, json.dumps(self._functions[name](event)).encode())
        except FunctionError as error:
            return Answer(200, {"X-Amz-Function-Error": "Unhandled"}, json.dumps(error.payload).encode())

    def _accept(self, name: str, event: Any) -> Answer:
        address = Address(INVOKE, name, str(uuid.uuid4()))
        if self._outbox:
            try:
                self._outbox.persist(Change(address, Content(json.dumps(event).encode())))
            except NotDurableError as error:
                return _error(507, "InsufficientStorage", str(error))
        self._submit(address, event)
        return Answer(202, {}, b"")

    def _submit(self, address: Address, event: Any) -> None:
        with self._idle:
            self._unfinished += 1
        self._workers.submit(self._run, address, event)

    def _run(self, address: Address, event: Any) -> None:
        try:
            self._deliver(address, event)
        finally:
            with self._idle:
                self._unfinished -= 1
                self._idle.notify_all()

    def _deliver(self, address: Address, event: Any) -> None:
        function = self._functions[address.container]
        if self._lasting and self._closing.is_set() and time.monotonic() > self._deadline:
            return
        done, failed = [Change(address, None)], {}
        for attempt in range(1 + function.spec.retries):
            if attempt and self._closing.wait(self._pauses[min(attempt, len(self._pauses)) - 1]):
                _log.warning("%s: a call that failed is left for the next start", address.container)
                return
            try:
                function(event, address.key)
                break
            except FunctionError as error:  # logged where it happened
                failed = error.payload
        else:
            _log.error(
                "%s: a call failed %d times and is given up", address.container, 1 + function.spec.retries
            )
            if function.spec.failures:
                done.append(self._failure(function.spec, address, event, failed))
        if self._outbox:
            try:
                self._outbox.persist(*done)
            except NotDurableError as error:
                _log.error("%s: a call that is done will be delivered again: %s", address.container, error)

    def _failure(self, spec: FunctionSpec, address: Address, event: Any, answer: Any) -> Change:
        """Make the dead-letter record of an invocation that failed every time.

        Source: AWS Lambda developer guide, "Capturing records of Lambda asynchronous invocations".
        """
        record = {
            "version": "1.0",
            "timestamp": datetime.fromtimestamp(self._clock(), UTC).isoformat(timespec="milliseconds"),
            "requestContext": {
                "requestId": address.key,
                "functionArn": f"arn:aws:lambda:{REGION}:{ACCOUNT}:function:{spec.name}:$LATEST",
                "condition": "RetriesExhausted",
                "approximateInvokeCount": 1 + spec.retries,
            },
            "requestPayload": event,
            "responseContext": {
                "statusCode": 200,
                "executedVersion": "$LATEST",
                "functionError": "Unhandled",
            },
            "responsePayload": answer,
        }
        place = Address(FAILURE, spec.failures or "", address.key)
        return Change(place, Content(json.dumps(record).encode()))


def _error(status: int, code: str, text: str) -> Answer:
    headers = {"content-type": "application/json", "x-amzn-ErrorType": code}
    return Answer(status, headers, json.dumps({"Type": "User", "message": text}).encode())
