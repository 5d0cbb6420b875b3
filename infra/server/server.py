"""The server in this process: data folder, jobs, upkeep, and the application."""

import logging
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import uvicorn
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.lookup.result_page import shared_page
from calibdb.service import Service
from calibdb.store import Store
from calibdb.store.ports import Jobs, Storage
from calibdb.store.sqlite import SqliteJobs, SqliteObjects, SqliteTable
from calibdb.store.storage import opened
from infra.server import jobs
from infra.server.app import ORIGINS, App, Public
from infra.server.folder import KEYPOINTS, SITE, Folder
from infra.server.pages import Pages, PublicObjects
from infra.server.protocol import TimedProtocol
from infra.web_build.root_files import contacts, public_settings
from infra.web_build.site import WEB, Options

# Accepted on loopback only, and from pages of this machine only.
DEVELOPMENT_TOKEN = "cdb_dev_local"  # noqa: S105
STOP_TIMEOUT_S = 2.0
"""Time that requests and a job have to finish when the server stops."""
_CHECKPOINT_S, _SWEEP_S = 10.0, 600.0
_DUMP_S = 3600.0  # between two looks whether the weekly dump is due
_DAY_S = 86_400
# As the rules of the buckets in template.yaml.
LIFETIMES = {
    (KEYPOINTS, "sessions/"): 2 * _DAY_S,
    (KEYPOINTS, "rigs/"): 2 * _DAY_S,
    (KEYPOINTS, "dumps/"): 7 * _DAY_S,
    (SITE, "dumps/2"): 35 * _DAY_S,
}
# Variables of this process, and the parameters of the template that they set on AWS.
OPERATOR_PARAMETERS = {
    "OPERATOR_NAME": "OperatorName",
    "OPERATOR_CONTACT": "OperatorContact",
    "IMPRINT": "Imprint",
}
_THREADS = max(4, 2 * (os.cpu_count() or 1))

_log = logging.getLogger("infra.server")


@dataclass(eq=False)
class Server:
    """The service over one data folder within the block. One at a time in a process.

    The start of the block raises FolderError, SecretsError or PortInUseError.
    """

    data: Path | None = None  # None: in memory
    environment: Mapping[str, str] = field(default_factory=dict)  # of the functions, over the server's own
    port: int = 0  # 0: any free one
    _: KW_ONLY
    host: str = "127.0.0.1"
    public: Public = field(default_factory=Public)
    web: Path = WEB
    clock: Callable[[], float] = time.time  # of storage, unix seconds
    pauses_s: Sequence[float] = jobs.PAUSES_S  # before a job that failed runs again
    stop_timeout_s: float = 60.0  # for a running job when the block ends
    new_secrets: bool = False
    # Number of this process among several over the folder, which another one has checked; None: the only one.
    # None and 0 run jobs and upkeep.
    worker: int | None = None
    inherited: socket.socket | None = None

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._start(stack)
            self._running = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._running.close()

    def _start(self, stack: ExitStack) -> None:
        is_worker = self.worker is not None
        folder = Folder(self.data, self.clock, new_secrets=self.new_secrets, as_worker=is_worker)
        stack.callback(folder.close)
        self.folder = folder
        self.damage = tuple(folder.damage)
        self.listener = self.inherited or bind(self.host, self.port)
        stack.callback(self.listener.close)
        self.url = self.public.url or f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        """Address of the site, without slash."""
        own = variables(folder, self.url, is_public=self.public.url is not None)
        self.environment = own | dict(self.environment)
        self.jobs = SqliteJobs(folder.database, jobs.run)
        self.storage = stack.enter_context(opened_for_functions(folder, self.jobs, self.environment))
        self.token = self._admit_token()
        named = {name: os.environ.get(variable, "") for variable, name in OPERATOR_PARAMETERS.items()}
        settings, options = public_settings(self.token, named), Options(self.url, contacts(named))
        self.pages = Pages(self.web, settings, options, partial(shared_page, store=Store.over(self.storage)))
        threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="function")
        stack.callback(threads.shutdown, wait=self.data is None or not is_worker, cancel_futures=True)
        dumps = PublicObjects(SqliteObjects(folder.database, SITE))
        app: Any = App(self.pages, dumps, threads, self.public)
        self.app: Any = ProxyHeadersMiddleware(app, list(self.public.proxies)) if self.public.proxies else app
        if not is_worker or self.worker == 0:
            upkeep = Upkeep(folder, self.jobs)
            upkeep.start()
            stack.callback(upkeep.stop)
            worker = jobs.JobWorker(self.jobs, self.pauses_s)
            worker.start()
            stack.callback(worker.stop, self.stop_timeout_s)

    def _admit_token(self) -> str:
        """Return the token of the site's pages: the development token, or one for the public address."""
        tokens = Store.over(self.storage).tokens
        now = int(self.clock())
        if self.public.url is None:
            _, token_id, secret = DEVELOPMENT_TOKEN.split("_")
            token = ApiToken(token_id, secret_hash(secret), ORIGINS, plan="development", created=now)
            stored = tokens.get(token_id)
            if stored is None or stored.origins != ORIGINS:
                tokens.change(replace(stored or token, origins=ORIGINS))
            return DEVELOPMENT_TOKEN
        # Derived from a secret of the folder, so that every process and every start has the same one.
        digest = secret_hash(f"{self.folder.secrets.session}\0page\0{self.public.url}")
        token_id, secret = digest[:12], digest[12:44]
        if tokens.get(token_id) is None:
            origins = (self.public.url,)
            tokens.change(ApiToken(token_id, secret_hash(secret), origins, plan="page", created=now))
        if (stored := tokens.get("dev")) is not None:
            tokens.revoke(stored, now)
        return f"cdb_{token_id}_{secret}"

    def wait_until_idle(self, seconds: float) -> None:
        """Wait until no job is unfinished; raises TimeoutError."""
        end = time.monotonic() + seconds
        while unfinished := self.jobs.unfinished():
            if time.monotonic() > end:
                raise TimeoutError(f"{unfinished} jobs unfinished after {seconds:g} s")
            time.sleep(0.01)

    @contextmanager
    def serve(self) -> Iterator[str]:
        """Serve in a thread until the end of the block; yields the address."""
        if self.listener.fileno() == -1:
            self.listener = bind(self.host, int(self.url.rpartition(":")[2]))
        with serving(self.app, self.listener):
            yield self.url


@contextmanager
def serving(app: Any, listener: socket.socket) -> Iterator[None]:
    """Serve in a thread until the end of the block, and close the socket."""
    server = http_server(app)
    thread = threading.Thread(target=server.run, args=([listener],), name="server")
    thread.start()
    try:
        while not server.started:
            if not thread.is_alive():
                raise RuntimeError("the server did not start; its log says why")
            time.sleep(0.005)
        yield
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


def http_server(app: Any) -> uvicorn.Server:
    """Make the HTTP server of an application."""
    return uvicorn.Server(
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


class Upkeep(threading.Thread):
    """A thread that copies the log into the database, deletes what has expired, and has dumps written."""

    def __init__(self, folder: Folder, queue: Jobs) -> None:
        super().__init__(name="upkeep", daemon=True)
        self._folder = folder
        self._queue = queue
        self._ending = threading.Event()

    def stop(self) -> None:
        """Stop the thread."""
        self._ending.set()
        self.join()

    def run(self) -> None:
        """Work until `stop`."""
        next_sweep, next_dump = 0.0, time.monotonic() + _DUMP_S
        while True:
            now = time.monotonic()
            try:
                if now >= next_sweep:
                    self._folder.database.sweep(LIFETIMES)
                    next_sweep = now + _SWEEP_S
                if now >= next_dump:
                    self._queue.later("dump", b"{}")
                    next_dump = now + _DUMP_S
                self._folder.database.checkpoint()
            except Exception:  # noqa: BLE001 - a full disk now may have room later
                _log.exception("upkeep of the database failed")
            if self._ending.wait(_CHECKPOINT_S):
                return


class PortInUseError(OSError):
    """The port cannot be used."""


def bind(host: str, port: int) -> socket.socket:
    """Return a listening socket; port 0: any free one. Raises PortInUseError."""
    if not 0 <= port < 2**16:
        raise PortInUseError(f"port {port} does not exist: choose one from 1 to 65535")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=1024)
    except OSError as error:
        raise PortInUseError(f"port {port} cannot be used: {error.strerror}") from error


def variables(folder: Folder, url: str, *, is_public: bool = False) -> dict[str, str]:
    """Return the environment of the functions over a folder."""
    environment = {
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
        environment["THRESHOLDS"] = "MIN_CONTRIBUTORS=1,CONTRIBUTOR_PERIOD=0"
    names = ("THRESHOLDS", "NEW_TOKENS", "PLAN_FACTORS", "PROCESSOR_FACTOR")
    return environment | {name: os.environ[name] for name in names if os.environ.get(name)}


@contextmanager
def opened_for_functions(folder: Folder, queue: Jobs, environment: Mapping[str, str]) -> Iterator[Storage]:
    """Have the functions use the folder within the block."""
    database = folder.database
    storage = Storage(
        SqliteTable(database), SqliteObjects(database, KEYPOINTS), queue, SqliteObjects(database, SITE)
    )
    with variables_set(environment), opened(storage):
        yield storage


@contextmanager
def variables_set(wanted: Mapping[str, str]) -> Iterator[None]:
    """Set variables of the environment within the block; the functions of this process read them again."""
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    Service.forget()
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
        Service.forget()
