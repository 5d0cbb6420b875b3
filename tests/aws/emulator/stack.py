"""The whole deployment in this process."""

from __future__ import annotations

import os
import sys
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

from infra.deploy.intrinsics import TemplateError
from infra.server import secrets
from infra.server.app import ORIGINS
from infra.server.server import DEVELOPMENT_TOKEN, OPERATOR_PARAMETERS, bind, serving
from infra.web_build.root_files import contacts, public_settings
from infra.web_build.site import Options
from tests.aws.emulator import environment as env
from tests.aws.emulator.events import Request, Response, message
from tests.aws.emulator.functions import Function, FunctionError
from tests.aws.emulator.gateway import INTEGRATION_TIMEOUT_S, Gateway
from tests.aws.emulator.intercept import Service, intercepting
from tests.aws.emulator.invokes import SHUTDOWN_GRACE_S, Invokes
from tests.aws.emulator.journal import Journal
from tests.aws.emulator.server import GatewayApp
from tests.aws.emulator.storage import Storage
from tests.aws.emulator.template import Template, load

ROOT = Path(__file__).resolve().parents[3]
# Variables of this process, and the parameters of the template that they set.
_PARAMETERS = {**OPERATOR_PARAMETERS, "NEW_TOKENS": "NewTokens"}
# A few more than can compute at once, for those that wait for the disk. More only make everyone wait longer.
_THREADS = max(4, 2 * (os.cpu_count() or 1))


class LocalStack:
    """A template's functions, routes and storage while its block lasts. One at a time in a process.

    Parameters
    ----------
    data_dir
        Folder where everything is kept; None: in memory, and gone afterwards.
    environment
        Variables of the functions, over the template's.
    port
        Where `serve` will listen on the loopback interface; 0: anywhere free.
    template, web
        The template and the static client; the repository's unless told otherwise.
    clock
        Unix seconds.
    retry_pauses
        Seconds before the retries of an asynchronous invoke that failed; see `Invokes`.
    answers_preflights
        Whether the gateway answers every preflight by itself; see `Gateway`.
    shutdown_grace_s, executor
        Time that waiting asynchronous invokes have at the end, and what runs them; see `Invokes`.

    new_secrets
        Whether new secrets take the place of those of the folder.

    Raises
    ------
    JournalError, SecretsError
        At the start of the block, if files of the folder are missing or damaged beyond reading.
    JournalError, PortInUseError
        At the start of the block, if another process has the folder or the port.
    TemplateError
        If the template cannot be run, or storage is elsewhere and it is not said where.
    """

    def __init__(
        self,
        data_dir: Path | None = None,
        environment: Mapping[str, str] | None = None,
        port: int = 0,
        template: Path = ROOT / "template.yaml",
        web: Path = ROOT / "web",
        clock: Callable[[], float] = time.time,
        retry_pauses: Sequence[float] = (1.0, 2.0),
        shutdown_grace_s: float = SHUTDOWN_GRACE_S,
        executor: Executor | None = None,
        answers_preflights: bool = False,
        *,
        new_secrets: bool = False,
    ):
        self._answers_preflights = answers_preflights
        self._data_dir = data_dir
        self._environment = environment or {}
        self._port = port
        self._template_path = template
        self._web = web
        self._clock = clock
        self._retry_pauses = retry_pauses
        self._shutdown_grace_s = shutdown_grace_s
        self._executor = executor
        self._new_secrets = new_secrets
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._start(stack)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def _start(self, stack: ExitStack) -> None:
        self.embedded = not env.storage_is_elsewhere(os.environ)
        # First of all, for it keeps a second process off the folder.
        journal, own = self._open_data_dir()
        stack.callback(journal.close)
        self._listener = stack.enter_context(bind("127.0.0.1", self._port))
        self._port = self._listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self._port}"
        """URL of `serve`, without slash."""

        self.template = self._load()
        # Themselves, not where they are: there is no parameter store here.
        variables = self.template.environment() | {
            "SECRETS_PATH": "",
            "SESSION_SECRETS": own.session,
            "CONTRIBUTOR_SECRET": own.contributor,
        }
        if not self.embedded:
            variables |= _elsewhere(self.template, variables, os.environ)
        self.environment = variables | dict(self._environment)
        stack.enter_context(env.set_variables(self.environment, embedded=self.embedded))
        for layer in map(str, self.template.layers):
            if layer not in sys.path:
                sys.path.append(layer)

        self.functions = {name: Function(spec) for name, spec in self.template.functions.items()}
        self.storage = (
            Storage(journal, self.template.tables, self.template.buckets, self._clock())
            if self.embedded
            else None
        )
        self.damage = tuple(journal.damage)
        """Sentences about what of the data folder was found damaged, each with the way on."""
        services: dict[str, Service] = {}
        if self.storage:
            stack.callback(self.storage.close)
            services = {name: _bind_service(self.storage, name) for name in ("dynamodb", "s3")}
        invokes = Invokes(
            self.functions,
            self.storage,
            self._data_dir is not None,
            self._retry_pauses,
            shutdown_grace_s=self._shutdown_grace_s,
            executor=self._executor,
        )
        stack.enter_context(intercepting(services | {"lambda": invokes.handle}))
        stack.callback(invokes.close)
        self.failures = invokes.failures
        """Reads the dead-letter queue: invocations that failed every time, as Lambda records them."""
        self.wait_until_idle = invokes.wait_until_idle
        """Waits until no asynchronous call is unfinished; see `Invokes.wait_until_idle`."""
        self.workers = ThreadPoolExecutor(_THREADS, thread_name_prefix="function")
        stack.callback(self.workers.shutdown)
        self.gateway = Gateway(
            self.template,
            self.functions,
            self._clock,
            lambda: str(uuid.uuid4()),
            self._answers_preflights,
        )
        if self.embedded:
            self._admit_development_token()
        invokes.redeliver_pending()

    def _open_data_dir(self) -> tuple[Journal, secrets.Secrets]:
        """Open the folder's two files. Either shows that the other was there, and is not to be made anew."""
        if self._data_dir is None:
            return Journal(None), secrets.generate()
        path = self._data_dir / "secrets.json"
        if self._new_secrets and path.exists():
            path.replace(path.with_suffix(".old"))
        journal = Journal(self._data_dir / "journal.sqlite", known=path.exists())
        try:
            return journal, secrets.load(path, known=not self._new_secrets and journal.has_records())
        except BaseException:
            journal.close()
            raise

    def _load(self) -> Template:
        parameters = {"GuidanceUrl": f"{self.url}/calibrate/"}
        for variable, name in _PARAMETERS.items():
            if variable in os.environ:
                parameters[name] = os.environ[variable]
        if self.embedded:
            # On one's own machine everyone is one contributor, and every capture and check counts.
            parameters["Thresholds"] = "MIN_CONTRIBUTORS=1,CONTRIBUTOR_PERIOD=0"
        self._parameters = parameters
        return load(self._template_path, parameters)

    def _admit_development_token(self) -> None:
        if "TABLE_NAME" not in self.environment:
            return  # another deployment, which knows no tokens
        # Here and not above: the layers are on the path only now.
        from calibdb.access.tokens import ApiToken, secret_hash
        from calibdb.settings import Settings
        from calibdb.store import Store

        _, token_id, secret = DEVELOPMENT_TOKEN.split("_")
        created = int(self._clock())
        token = ApiToken(token_id, secret_hash(secret), ORIGINS, plan="development", created=created)
        tokens = Store.of(Settings.from_environment(self.environment)).tokens
        stored = tokens.get(token_id)
        if stored is None or stored.origins != ORIGINS:  # not yet, lost, or of an earlier release
            known = {each.id: each for each in tokens.all()}.get(token_id, token)
            tokens.change(replace(known, origins=ORIGINS))

    def warm(self) -> tuple[str, ...]:
        """Load all functions now; return the names of those that could not be, and that will answer 500."""
        failed = []
        for name, function in self.functions.items():
            try:
                function.warm()
            except FunctionError:  # logged where it happened
                failed.append(name)
        return tuple(failed)

    def request(
        self,
        method: str,
        path: str,
        headers: Mapping[str, str] | None = None,
        query: str = "",
        body: bytes = b"",
    ) -> Response:
        """Send a request through the gateway without a socket.

        `path` and `query` are percent-encoded, as on the wire; `query` is without its question mark.
        """
        host = {"host": self.url.removeprefix("http://")}
        request = Request(method, path, query, tuple((host | dict(headers or {})).items()), body)
        try:
            return self.workers.submit(self.gateway.handle, request).result(INTEGRATION_TIMEOUT_S)
        except TimeoutError:
            return message(503, "Service Unavailable")

    @contextmanager
    def serve(self, port: int = 0) -> Iterator[str]:
        """Serve API and client on the loopback interface until the end of the block; yields the address.

        Raises
        ------
        ValueError
            If a port is named that is not the stack's: the functions were told another address.
        """
        if port not in (0, self._port):
            raise ValueError(f"the stack was made for port {self._port}; give it the port {port} instead")
        if self._listener.fileno() == -1:  # closed when it was served before
            self._listener = bind("127.0.0.1", self._port)
        settings = public_settings("/v1", DEVELOPMENT_TOKEN, self._parameters)
        app = GatewayApp(
            self.gateway,
            self.workers,
            self._web,
            settings,
            options=Options(self.url, contacts(self._parameters)),
        )
        with serving(app, self._listener):
            yield self.url


def _elsewhere(template: Template, variables: Mapping[str, str], given: Mapping[str, str]) -> dict[str, str]:
    """Return what the operator's environment says of the variables; what the template creates it must say."""
    created = {table.name for table in template.tables} | {bucket.name for bucket in template.buckets}
    missing = [name for name, value in variables.items() if value in created and name not in given]
    if missing:
        raise TemplateError(f"storage is elsewhere, but {' and '.join(missing)} do not say where")
    return {name: given[name] for name in variables if name in given}


def _bind_service(storage: Storage, service: str) -> Service:
    return lambda operation, request: storage.handle(service, operation, request)
