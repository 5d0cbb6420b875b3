"""Lambda's part: a function's handler, loaded from its file and called with what Lambda would hand it."""

from __future__ import annotations

import importlib.util
import json
import logging
import sys
import threading
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tests.aws.emulator.template import FunctionSpec

_log = logging.getLogger("tests.aws.emulator.functions")


class FunctionError(Exception):
    """A handler could not be loaded, raised, or answered with what JSON cannot carry.

    `payload` is what Lambda hands an invoker then: `errorMessage` and `errorType`.
    """

    def __init__(self, function: str, error: Exception):
        super().__init__(f"{function}: {type(error).__name__}: {error}")
        self.payload = {"errorMessage": str(error), "errorType": type(error).__name__}


@dataclass(frozen=True)
class Context:
    """The `context` argument of a handler, with Lambda's names."""

    function_name: str
    memory_limit_in_mb: int
    aws_request_id: str
    deadline: float
    """Monotonic seconds."""

    def get_remaining_time_in_millis(self) -> int:
        """Return the milliseconds left until the function's timeout."""
        return max(0, round((self.deadline - time.monotonic()) * 1000))


class Function:
    """One function, loaded at its first call, as Lambda does at a cold start.

    On AWS an instance serves one call at a time; here one instance serves them all, each in a thread of its
    own.
    """

    def __init__(self, spec: FunctionSpec):
        self.spec = spec
        self._handler: Callable[[Any, Context], Any] | None = None
        self._loading = threading.Lock()

    def warm(self) -> Callable[[Any, Context], Any]:
        """Return the handler, loaded now if it was not yet.

        Raises
        ------
        FunctionError
            If it cannot be loaded; the traceback is in the log.
        """
        with self._loading:
            if self._handler is None:
                try:
                    self._handler = _load(self.spec)
                except Exception as error:
                    # Lambda's boundary: whatever a function's code raises while it is loaded is the
                    # function's.
                    _log.exception("%s could not be loaded", self.spec.name)
                    raise FunctionError(self.spec.name, error) from error
            return self._handler

    def __call__(self, event: Any, request_id: str | None = None) -> Any:
        """Invoke; event and answer pass through JSON, as they do between AWS's services.

        Raises
        ------
        FunctionError
            If the handler did not answer; the traceback is in the log.
        """
        handler = self.warm()
        context = Context(
            function_name=self.spec.name,
            memory_limit_in_mb=self.spec.memory,
            aws_request_id=request_id or str(uuid.uuid4()),
            deadline=time.monotonic() + self.spec.timeout,
        )
        try:
            return json.loads(json.dumps(handler(json.loads(json.dumps(event)), context)))
        except Exception as error:
            # Lambda's boundary again: a handler may raise anything.
            _log.exception("%s failed (request %s)", self.spec.name, context.aws_request_id)
            raise FunctionError(self.spec.name, error) from error


def _load(spec: FunctionSpec) -> Callable[[Any, Context], Any]:
    # By file path under a name of its own: every function calls its module "app".
    module_name, _, attribute = spec.handler.rpartition(".")
    path = spec.code / f"{module_name}.py"
    unique = f"calibdb_function_{spec.name}_{uuid.uuid4().hex}"
    found = importlib.util.spec_from_file_location(unique, path)
    if found is None or found.loader is None:
        raise ImportError(f"{path} is not a Python module")
    module = importlib.util.module_from_spec(found)
    # Registered as an import would: dataclasses and pydantic look a class's module up there.
    sys.modules[unique] = module
    try:
        found.loader.exec_module(module)
    except BaseException:
        del sys.modules[unique]
        raise
    handler: Callable[[Any, Context], Any] = getattr(module, attribute)
    return handler
