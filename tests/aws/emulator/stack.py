"""The whole deployment in this process."""

import asyncio
import os
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Self
from unittest.mock import patch

from starlette.requests import Request as WebRequest
from starlette.responses import Response as WebResponse
from starlette.types import Receive, Scope, Send

from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from infra.server import secrets
from infra.server.app import ORIGINS
from infra.server.server import DEVELOPMENT_TOKEN, bind, serving
from tests.aws.emulator.events import Request, message
from tests.aws.emulator.functions import Function, Invokes
from tests.aws.emulator.gateway import INTEGRATION_TIMEOUT_S, Gateway
from tests.aws.emulator.intercept import intercepting
from tests.aws.emulator.intrinsics import REGION
from tests.aws.emulator.storage import Storage
from tests.aws.emulator.template import load
from tests.helpers.service.in_process import Response

_LOCAL = {
    "AWS_ACCESS_KEY_ID": "local",
    "AWS_SECRET_ACCESS_KEY": "local",  # signs requests that never leave the process
    "AWS_CONFIG_FILE": os.devnull,
    "AWS_SHARED_CREDENTIALS_FILE": os.devnull,
    "AWS_EC2_METADATA_DISABLED": "true",
    "AWS_REGION": REGION,
    "AWS_DEFAULT_REGION": REGION,
}


@dataclass(eq=False)
class LocalStack:
    """The template's functions, routes and storage while its block lasts. One at a time in a process.

    `environment`: variables of the functions, over the template's.
    """

    environment: Mapping[str, str] = field(default_factory=dict)

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._start(stack)
            self._running = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._running.close()

    def _start(self, stack: ExitStack) -> None:
        self._listener = stack.enter_context(bind("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        # One user is one contributor, and every capture and check counts.
        parameters = {
            "GuidanceUrl": f"{self.url}/calibrate/",
            "Thresholds": "MIN_CONTRIBUTORS=1,CONTRIBUTOR_PERIOD=0",
        }
        self.template = load(parameters)
        own = secrets.generate()
        self.environment = {
            **self.template.environment(),
            # The secrets themselves: the emulator has no parameter store.
            "SECRETS_PATH": "",
            "SESSION_SECRETS": own.session,
            "CONTRIBUTOR_SECRET": own.contributor,
            **self.environment,
        }
        # Other variables of AWS would lead boto3 away from the storage of this process.
        own_variables = {name: value for name, value in os.environ.items() if not name.startswith("AWS_")}
        stack.enter_context(patch.dict(os.environ, own_variables | _LOCAL | self.environment, clear=True))
        Service.forget()
        stack.callback(Service.forget)
        self.functions = {name: Function(spec) for name, spec in self.template.functions.items()}
        invokes = Invokes(self.functions)
        storage = Storage()
        services = {"dynamodb": storage.handle, "s3": storage.handle, "lambda": invokes.handle}
        stack.enter_context(intercepting(services))
        stack.callback(storage.empty)
        stack.callback(invokes.close)
        storage.create(self.template.tables, self.template.buckets)
        self.wait_until_idle = invokes.wait_until_idle
        self.workers = ThreadPoolExecutor(thread_name_prefix="function")
        stack.callback(self.workers.shutdown)
        self.gateway = Gateway(self.template, self.functions)
        _, token_id, secret = DEVELOPMENT_TOKEN.split("_")
        token = ApiToken(token_id, secret_hash(secret), ORIGINS, "development", int(time.time()))
        Store.of(Settings.from_environment(self.environment)).tokens.change(token)

    def request(
        self,
        method: str,
        path: str,
        headers: Mapping[str, str] | None = None,
        query: str = "",
        body: bytes = b"",
    ) -> Response:
        """Send a request through the gateway without a socket; `path` and `query` are percent-encoded."""
        host = {"host": self.url.removeprefix("http://")}
        request = Request(method, path, query, tuple((host | dict(headers or {})).items()), body)
        try:
            return self.workers.submit(self.gateway.handle, request).result(INTEGRATION_TIMEOUT_S)
        except TimeoutError:
            return message(503, "Service Unavailable")

    @contextmanager
    def serve(self) -> Iterator[str]:
        """Serve the API on the loopback interface until the end of the block, once; yield the address."""

        async def answer(scope: Scope, receive: Receive, send: Send) -> None:
            request = Request(
                scope["method"],
                scope["raw_path"].decode("latin-1"),
                scope["query_string"].decode("latin-1"),
                tuple((name.decode("latin-1"), value.decode("latin-1")) for name, value in scope["headers"]),
                await WebRequest(scope, receive).body(),
            )
            loop = asyncio.get_running_loop()
            response = await loop.run_in_executor(self.workers, self.gateway.handle, request)
            await WebResponse(response.body, response.status, dict(response.headers))(scope, receive, send)

        with serving(answer, self._listener):
            yield self.url
