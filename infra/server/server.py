"""The server in this process: data folder, jobs, upkeep, and the application."""

from __future__ import annotations

import asyncio
import logging
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import uvicorn
from starlette.types import ASGIApp

from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.service import Service
from calibdb.store import Store
from calibdb.store.ports import Jobs, Storage
from calibdb.store.sqlite import SqliteJobs, SqliteObjects, SqliteTable
from calibdb.store.storage import opened
from infra.server import jobs
from infra.server.app import App, Public
from infra.server.folder import KEYPOINTS, SITE, Folder
from infra.server.loopback import ORIGINS
from infra.server.pages import Pages, PublicObjects, contacts, public_settings
from infra.server.protocol import TimedProtocol
from infra.web_build.site import WEB, Options

# Accepted on loopback only, and from pages of this machine only.
DEVELOPMENT_TOKEN = "cdb_dev_local"  # noqa: S105
STOP_TIMEOUT_S = 2.0
"""Time that requests and a job have to finish when the server stops."""
_CHECKPOINT_S, _SWEEP_S = 10.0, 600.0
_DAY_S = 86_400
# As the rules of the buckets in template.yaml.
LIFETIMES = {
    (KEYPOINTS, "sessions/"): 2 * _DAY_S,
    (KEYPOINTS, "rigs/"): 2 * _DAY_S,
    (KEYPOINTS, "dumps/"): 7 * _DAY_S,
    (SITE, "dumps/2"): 35 * _DAY_S,
}
# Variables of this process, and the parameters of the template that they set on AWS.
_PARAMETERS = {
    "OPERATOR_NAME": "OperatorName",
    "OPERATOR_CONTACT": "OperatorContact",
    "IMPRINT": "Imprint",
}
_THREADS = max(4, 2 * (os.cpu_count() or 1))

_log = logging.getLogger("infra.server")


@dataclass(frozen=True)
class Response:
    """A response, as `Server.request` returns it; header names are lower case."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class Server:
    """The service over one data folder within the block. One at a time in a process.

    Parameters
    ----------
    data
        The folder; None: in memory.
    environment
        Variables of the functions, over the server's own.
    port, host
        Where `serve` listens; port 0: any free one.
    public
        Who may reach it.
    web
        The static client.
    clock
        Unix seconds, of storage.
    pauses_s
        Pauses before a job that failed runs again.
    stop_timeout_s
        Time for a running job when the block ends.
    new_secrets
        Replace the secrets of the folder.
    worker
        Number of this process among several over the folder, which another process has checked; None: the
        only one. The first one runs jobs and upkeep.

    Raises
    ------
    FolderError, SecretsError
        At the start of the block, if the folder cannot be used.
    PortInUseError
        At the start of the block, if the port cannot be used.
    """

    def __init__(
        self,
        data: Path | None = None,
        environment: Mapping[str, str] | None = None,
        port: int = 0,
        *,
        host: str = "127.0.0.1",
        public: Public | None = None,
        web: Path = WEB,
        clock: Callable[[], float] = time.time,
        pauses_s: Sequence[float] = jobs.PAUSES_S,
        stop_timeout_s: float = 60.0,
        new_secrets: bool = False,
        worker: int | None = None,
        listener: socket.socket | None = None,
    ) -> None:
        self._data = data
        self._environment = environment or {}
        self._port = port
        self._host = host
        self._listener = listener
        self.public = public or Public()
        self._web = web
        self._clock = clock
        self._pauses_s = pauses_s
        self._stop_timeout_s = stop_timeout_s
        self._new_secrets = new_secrets
        self._worker = worker
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
        is_worker = self._worker is not None
        folder = Folder(self._data, self._clock, new_secrets=self._new_secrets, as_worker=is_worker)
        stack.callback(folder.close)
        self.folder = folder
        self.damage = tuple(folder.damage)
        """Sentences about damage that was found in the folder."""
        self.listener = self._listener or bind(self._host, self._port)
        stack.callback(self.listener.close)
        self.url = self.public.url or f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        """Address of the site, without slash."""
        self.environment = variables(folder, self.url, is_public=self.public.url is not None)
        self.environment |= self._environment
        self._jobs = SqliteJobs(folder.database, jobs.run)
        self.storage = stack.enter_context(opened_for_functions(folder, self._jobs, self.environment))
        self.token = self._admit_token()
        """Token of the site's own pages."""
        self._parameters = {name: os.environ[v] for v, name in _PARAMETERS.items() if os.environ.get(v)}
        options = Options(self.url, contacts(self._parameters))
        settings = public_settings("/v1", self.token, self._parameters)
        self.pages = Pages(self._web, settings, options)
        threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="function")
        stack.callback(threads.shutdown, wait=self._data is None or not is_worker, cancel_futures=True)
        self.app: ASGIApp = App(
            self.pages, PublicObjects(SqliteObjects(folder.database, SITE)), threads, self.public
        )
        if not is_worker or self._worker == 0:
            upkeep = Upkeep(folder)
            upkeep.start()
            stack.callback(upkeep.stop)
            worker = jobs.JobWorker(self._jobs, self._pauses_s)
            worker.start()
            stack.callback(worker.stop, self._stop_timeout_s)

    def _admit_token(self) -> str:
        """Return the token of the site's pages: the development token, or one for the public address."""
        tokens = Store.over(self.storage).tokens
        now = int(self._clock())
        if self.public.url is None:
            _, token_id, secret = DEVELOPMENT_TOKEN.split("_")
            token = ApiToken(token_id, secret_hash(secret), ORIGINS, plan="development", created=now)
            stored = tokens.get(token_id)
            if stored is None or stored.origins != ORIGINS:
                known = {each.id: each for each in tokens.all()}.get(token_id, token)
                tokens.change(replace(known, origins=ORIGINS))
            return DEVELOPMENT_TOKEN
        # Derived from a secret of the folder, so that every process and every start has the same one.
        digest = secret_hash(f"{self.folder.secrets.session}\0page\0{self.public.url}")
        token_id, secret = digest[:12], digest[12:44]
        if tokens.get(token_id) is None:
            origins = (self.public.url,)
            tokens.change(ApiToken(token_id, secret_hash(secret), origins, plan="page", created=now))
        if tokens.get("dev") is not None:
            stored = tokens.get("dev")
            assert stored is not None  # noqa: S101
            tokens.revoke(stored, now)
        return f"cdb_{token_id}_{secret}"

    def warm(self) -> None:
        """Make the pages, and load what the first requests need, now."""
        self.pages.warm()

    def failures(self) -> list[tuple[str, bytes, str]]:
        """Return name, payload and error of the jobs that failed every time."""
        return self._jobs.failures()

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no job is unfinished; raises TimeoutError."""
        end = time.monotonic() + seconds
        while unfinished := self._jobs.unfinished():
            if time.monotonic() > end:
                raise TimeoutError(f"{unfinished} jobs unfinished after {seconds:g} s")
            time.sleep(0.01)

    def request(
        self,
        method: str,
        path: str,
        headers: Mapping[str, str] | None = None,
        query: str = "",
        body: bytes = b"",
        client: str = "127.0.0.1",
    ) -> Response:
        """Send a request to the application without a socket.

        `path` and `query` are percent-encoded; `query` is without its question mark.
        """
        return asyncio.run(_request(self.app, method, path, headers or {}, query, body, client, self.url))

    @contextmanager
    def serve(self) -> Iterator[str]:
        """Serve in a thread until the end of the block; yields the address."""
        if self.listener.fileno() == -1:
            self.listener = bind(self._host, int(self.url.rpartition(":")[2]))
        server = HttpServer(self.app)
        thread = threading.Thread(target=server.run, args=([self.listener],), name="server")
        thread.start()
        try:
            while not server.started:
                if not thread.is_alive():
                    raise RuntimeError("the server did not start; its log says why")
                time.sleep(0.005)
            yield self.url
        finally:
            server.should_exit = True
            thread.join()
            self.listener.close()


class HttpServer(uvicorn.Server):
    """uvicorn with the server's options, which leaves signals to the command."""

    def __init__(self, app: ASGIApp) -> None:
        super().__init__(
            uvicorn.Config(
                app,
                loop="uvloop",
                http=TimedProtocol,
                ws="none",
                lifespan="off",
                log_config=None,
                access_log=False,
                server_header=False,
                proxy_headers=False,
                timeout_keep_alive=30,
                timeout_graceful_shutdown=round(STOP_TIMEOUT_S),
            )
        )

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signals alone."""
        yield


class Upkeep:
    """A thread that copies the log into the database, and deletes what has expired."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._work, name="upkeep", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop it."""
        self._stopping.set()
        self._thread.join()

    def _work(self) -> None:
        next_sweep = 0.0
        while True:
            try:
                if time.monotonic() >= next_sweep:
                    self._folder.database.sweep(LIFETIMES)
                    next_sweep = time.monotonic() + _SWEEP_S
                self._folder.database.checkpoint()
            except Exception:  # noqa: BLE001 - a full disk now may have room later
                _log.exception("upkeep of the database failed")
            if self._stopping.wait(_CHECKPOINT_S):
                return


class PortInUseError(OSError):
    """The port cannot be used."""


def bind(host: str, port: int) -> socket.socket:
    """Return a listening socket; port 0: any free one. Raises PortInUseError."""
    if not 0 <= port < 2**16:
        raise PortInUseError(f"port {port} does not exist: choose one from 1 to 65535")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # With the protocol by name, asyncio sets TCP_NODELAY on connections.
    taken = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        taken.bind((host, port))
    except OSError as error:
        taken.close()
        raise PortInUseError(f"port {port} cannot be used: {error.strerror}") from error
    return taken


def variables(folder: Folder, url: str, *, is_public: bool = False) -> dict[str, str]:
    """Return the environment of the functions over a folder."""
    found = {
        "TABLE_NAME": "items",
        "BUCKET_NAME": KEYPOINTS,
        "WEB_BUCKET_NAME": "",
        "SECRETS_PATH": "",
        "SESSION_SECRETS": folder.secrets.session,
        "CONTRIBUTOR_SECRET": folder.secrets.contributor,
        "GUIDANCE_URL": f"{url}/calibrate/",
        "REFIT_FUNCTION": "refit",
        "VERIFY_FUNCTION": "verify",
        "PROCESSOR_FACTOR": "2",
        "AWS_REGION": "local",
    }
    if not is_public:
        # On your own machine everyone is one contributor, and every capture and check counts.
        found["THRESHOLDS"] = "MIN_CONTRIBUTORS=1,CONTRIBUTOR_PERIOD=0"
    names = ("THRESHOLDS", "NEW_TOKENS", "PLAN_FACTORS", "PROCESSOR_FACTOR")
    return found | {name: os.environ[name] for name in names if os.environ.get(name)}


@contextmanager
def opened_for_functions(folder: Folder, queue: Jobs, environment: Mapping[str, str]) -> Iterator[Storage]:
    """Have the functions use the folder within the block."""
    database = folder.database
    storage = Storage(
        SqliteTable(database), SqliteObjects(database, KEYPOINTS), queue, SqliteObjects(database, SITE)
    )
    Service.forget()
    with variables_set(environment), opened(storage):
        yield storage
    Service.forget()


@contextmanager
def variables_set(wanted: Mapping[str, str]) -> Iterator[None]:
    """Set variables of the environment within the block."""
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


async def _request(
    app: ASGIApp,
    method: str,
    path: str,
    headers: Mapping[str, str],
    query: str,
    body: bytes,
    client: str,
    url: str,
) -> Response:
    from urllib.parse import unquote

    sent = {"host": url.partition("//")[2]} | {name.lower(): value for name, value in headers.items()}
    if body:
        sent["content-length"] = str(len(body))
    scope: dict[str, Any] = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "scheme": "http",
        "path": unquote(path),
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "root_path": "",
        "headers": [(name.encode("latin-1"), value.encode("latin-1")) for name, value in sent.items()],
        "client": (client, 50_000),
        "server": ("127.0.0.1", 80),
    }
    status, received, content = 0, {}, bytearray()

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message: Any) -> None:
        nonlocal status, received
        if message["type"] == "http.response.start":
            status = message["status"]
            received = {n.decode("latin-1").lower(): v.decode("latin-1") for n, v in message["headers"]}
        else:
            content.extend(message.get("body", b""))

    try:
        await app(scope, receive, send)
    except Exception:
        if not status:
            raise
        _log.exception("%s %s failed", method, path)  # after its answer, as uvicorn does
    return Response(status, received, b"" if method == "HEAD" else bytes(content))
