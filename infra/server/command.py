"""The command `calibdb-server`: its options, its processes, and signals."""

import argparse
import ctypes
import gc
import ipaddress
import logging
import os
import platform
import signal
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import FrameType
from urllib.parse import urlsplit

from calibdb.service import Service
from infra.server.app import Public, is_loopback
from infra.server.folder import Folder, FolderError
from infra.server.secrets import SecretsError
from infra.server.server import DEVELOPMENT_TOKEN, STOP_TIMEOUT_S, PortInUseError, Server, bind, http_server

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_M_ARENA_MAX = -8  # glibc's malloc.h; by default each thread has memory of its own, which only grows
_RESTART_PAUSE_S = 0.5  # before a process that ended is started again
_log = logging.getLogger("infra.server")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the server; return the exit status."""
    if platform.libc_ver()[0] == "glibc":
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, 1)
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S")
    logging.getLogger("infra").setLevel(logging.INFO)
    options = _parser().parse_args(arguments)
    try:
        public = _public(options)
        if options.workers == 1:
            server = Server(
                options.data,
                port=options.port,
                host=options.host,
                public=public,
                stop_timeout_s=STOP_TIMEOUT_S,
                new_secrets=bool(os.environ.get("NEW_SECRETS")),
            )
            return _serve(server, announce=True)
        return _supervise(options, public)
    except (FolderError, PortInUseError, SecretsError, ValueError) as error:
        print(f"calibDB cannot start: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="calibdb-server", description="calibDB over one SQLite file")
    environment = os.environ
    data = Path(environment.get("DATA_DIR") or ".data")
    parser.add_argument("--data", type=Path, metavar="DIR", default=data)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=environment.get("PORT") or "8000")
    parser.add_argument("--workers", type=int, metavar="N", default=environment.get("WORKERS") or "1")
    parser.add_argument("--public-url", metavar="URL", help="address of the site behind a proxy with TLS")
    parser.add_argument("--trusted-proxy", metavar="CIDR", action="append", default=[])
    return parser


def _public(options: argparse.Namespace) -> Public:
    url = options.public_url.rstrip("/") if options.public_url else None
    if options.workers < 1:
        raise ValueError("--workers is at least 1")
    if url is not None:
        parts = urlsplit(url)
        if parts.scheme not in ("https", "http") or not parts.netloc or parts.path:
            raise ValueError(f"--public-url is an address such as https://calibdb.example, not {url!r}")
    elif not is_loopback(options.host):
        raise ValueError(f"--host {options.host} is not this machine only: --public-url is required")
    return Public(url, tuple(str(ipaddress.ip_network(each)) for each in options.trusted_proxy))


def _serve(server: Server, *, announce: bool = False) -> int:
    """Serve until a signal, which uvicorn raises again when it has ended."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise SystemExit(0)

    for number in _SIGNALS:
        signal.signal(number, stop)
    with suppress(SystemExit), server:
        _warn(server.damage)
        server.pages.warm()
        # What exists by now mostly stays. The collector need not walk it in the middle of requests.
        gc.freeze()
        gc.enable()
        if announce:
            _announce(server.url, is_public=server.public.url is not None)
        with Service.in_server():
            http_server(server.app).run([server.listener])
    if announce:
        print("stopped")
    sys.stdout.flush()
    # A job or a request that has not ended by now runs again, or was not acknowledged.
    os._exit(0)


def _announce(url: str, *, is_public: bool) -> None:
    print(f"calibDB is at {url}/", flush=True)
    if not is_public:
        print(f"API token, for this machine only: {DEVELOPMENT_TOKEN}", flush=True)


def _warn(damage: Sequence[str]) -> None:
    for sentence in damage:
        print(f"warning: {sentence}", file=sys.stderr, flush=True)


def _supervise(options: argparse.Namespace, public: Public) -> int:
    """Check the folder, then keep `--workers` processes running over it until a signal."""
    # Its lock lasts until the last process ends that has inherited it.
    folder = Folder(options.data, new_secrets=bool(os.environ.get("NEW_SECRETS")))
    _warn(folder.damage)
    folder.database.close()
    listener = bind(options.host, options.port)
    alive, held = os.pipe()  # a process whose `alive` ends has lost this one
    processes: dict[int, int] = {}  # index by id
    stopping: list[int] = []

    def stop(number: int, _: FrameType | None) -> None:
        stopping.append(number)
        for process in list(processes):
            os.kill(process, signal.SIGTERM if len(stopping) == 1 else signal.SIGKILL)

    def start(index: int) -> bool:
        """Start a process; return True in that process."""
        signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)  # until the new process has its own handlers
        if process := os.fork():
            processes[process] = index
        else:
            os.close(held)
            threading.Thread(target=_end_with, args=(alive,), daemon=True).start()
            for number in _SIGNALS:
                signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
        return not process

    for number in _SIGNALS:
        signal.signal(number, stop)
    waiting = list(range(options.workers))
    _announce(public.url or f"http://127.0.0.1:{listener.getsockname()[1]}", is_public=public.url is not None)
    while processes or not stopping:
        while waiting and not stopping:
            if start(index := waiting.pop()):
                server = Server(
                    options.data,
                    public=public,
                    inherited=listener,
                    stop_timeout_s=STOP_TIMEOUT_S,
                    worker=index,
                )
                return _serve(server)
        process, status = os.wait()
        index = processes.pop(process)
        if not stopping:
            ended = os.waitstatus_to_exitcode(status)
            _log.error("process %d ended with status %d; it is started again", index, ended)
            time.sleep(_RESTART_PAUSE_S)
            waiting.append(index)
    print("stopped", flush=True)
    return 0


def _end_with(alive: int) -> None:
    """End this process when the one that started it has ended."""
    os.read(alive, 1)
    os.kill(os.getpid(), signal.SIGTERM)
