"""Lambda's part: a function's handler, called with what Lambda would hand it."""

import importlib
import json
import logging
import time
import uuid
from dataclasses import dataclass
from typing import Any

from infra.server.jobs import Context
from tests.aws.emulator.template import FunctionSpec

_log = logging.getLogger("tests.aws.emulator.functions")


class FunctionError(Exception):
    """A handler could not be loaded, raised, or answered with what JSON cannot carry."""


@dataclass
class Function:
    """One function. On AWS an instance serves one call at a time; here one serves them all, in threads."""

    spec: FunctionSpec

    def __call__(self, event: Any, request_id: str | None = None) -> Any:
        """Invoke; event and answer pass through JSON, as they do between AWS's services.

        Raises FunctionError if the handler did not answer; the traceback is in the log.
        """
        context = Context(request_id or str(uuid.uuid4()), time.monotonic() + self.spec.timeout)
        try:
            handler = importlib.import_module(self.spec.module).handler
            return json.loads(json.dumps(handler(json.loads(json.dumps(event)), context)))
        except Exception as error:
            # Lambda's boundary: a handler may raise anything.
            _log.exception("%s failed (request %s)", self.spec.name, context.aws_request_id)
            raise FunctionError(f"{self.spec.name}: {type(error).__name__}: {error}") from error
