"""The command `calibdb-server`: its options, its processes, and signals."""

from __future__ import annotations

import argparse
import gc
import ipaddress
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from urllib.parse import urlsplit

from calibdb.service import Service
from infra.server.app import Public
from infra.server.folder import Folder, FolderError
from infra.server.loopback import is_loopback
from infra.server.secrets import SecretsError
from infra.server.server import STOP_TIMEOUT_S, HttpServer, PortInUseError, Server, bind

_RESTART_PAUSE_S = 0.5  # before a process that ended is started again
_log = logging.getLogger("infra.server")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the server; return the exit status."""
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S")
    logging.getLogger("infra").setLevel(logging.INFO)
    options = _parser().parse_args(arguments)
    try:
        public = _public(options)
        if options.worker:
            return _work(options, public)
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
        return _supervise(options, public, list(sys.argv[1:] if arguments is None else arguments))
    except (FolderError, PortInUseError, SecretsError, ValueError) as error:
        print(f"calibDB cannot start: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="calibdb-server", description="calibDB over one SQLite file")
    environment = os.environ
    parser.add_argument(
        "--data", type=Path, metavar="DIR", default=Path(environment.get("DATA_DIR") or ".data")
    )
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=environment.get("PORT") or "8000")
    parser.add_argument("--workers", type=int, metavar="N", default=environment.get("WORKERS") or "1")
    parser.add_argument("--public-url", metavar="URL", help="address of the site behind a proxy with TLS")
    parser.add_argument("--trusted-proxy", metavar="CIDR", action="append", default=[])
    parser.add_argument("--worker", help=argparse.SUPPRESS)  # number and descriptors of a process
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
    return Public(url, tuple(ipaddress.ip_network(each) for each in options.trusted_proxy))


def _serve(server: Server, *, announce: bool) -> int:
    """Serve until a signal."""
    stopping = threading.Event()
    http: HttpServer | None = None

    def stop(number: int, _: FrameType | None) -> None:
        if stopping.is_set():
            os._exit(128 + number)
        stopping.set()
        if http is None:
            raise SystemExit(0)
        http.should_exit = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    with server:
        for sentence in server.damage:
            print(f"warning: {sentence}", file=sys.stderr, flush=True)
        server.warm()
        # What is there by now mostly stays; the collector need not walk it in the middle of requests.
        gc.freeze()
        gc.enable()
        http = HttpServer(server.app)
        if announce:
            _announce(server.url, server.token if server.public.url is None else None)
        with Service.in_server():
            http.run([server.listener])
        if announce:
            print("stopped", flush=True)
    # A job or a request that has not ended by now runs again, or was not acknowledged.
    sys.stdout.flush()
    os._exit(0)


def _announce(url: str, token: str | None) -> None:
    print(f"calibDB is at {url}/")
    if token is not None:
        print(f"API token, for this machine only: {token}")
    sys.stdout.flush()


def _supervise(options: argparse.Namespace, public: Public, arguments: list[str]) -> int:
    """Check the folder, then keep `--workers` processes running over it until a signal."""
    folder = Folder(options.data, new_secrets=bool(os.environ.get("NEW_SECRETS")))
    for sentence in folder.damage:
        print(f"warning: {sentence}", file=sys.stderr, flush=True)
    folder.database.close()
    listener = bind(options.host, options.port)
    listener.listen(1024)
    alive, held = os.pipe()  # a worker whose `alive` ends has lost this process
    lock = folder.lock
    assert lock is not None  # noqa: S101 - this process has opened the folder
    stopping: list[int] = []

    def stop(number: int, _: FrameType | None) -> None:
        stopping.append(number)
        for process in processes:
            process.send_signal(signal.SIGTERM if len(stopping) == 1 else signal.SIGKILL)

    def start(index: int) -> subprocess.Popen[bytes]:
        # A lock that is inherited lasts until the last process ends.
        passed = (listener.fileno(), alive, lock)
        return subprocess.Popen(  # noqa: S603 - this program
            [sys.executable, "-m", "infra.server", *arguments, "--worker", f"{index},{passed[0]},{alive}"],
            stdin=subprocess.DEVNULL,
            pass_fds=passed,
            env=os.environ | {"NEW_SECRETS": ""},
        )

    processes: list[subprocess.Popen[bytes]] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    processes += [start(index) for index in range(options.workers)]
    url = public.url or f"http://127.0.0.1:{listener.getsockname()[1]}"
    _announce(url, None if public.url else "cdb_dev_local")
    while not stopping:
        time.sleep(0.1)
        for index, process in enumerate(processes):
            if not stopping and process.poll() is not None:
                _log.error("process %d ended with status %s; it is started again", index, process.returncode)
                time.sleep(_RESTART_PAUSE_S)
                processes[index] = start(index)
    for process in processes:
        process.wait()
    os.close(held)
    print("stopped", flush=True)
    return 0


def _work(options: argparse.Namespace, public: Public) -> int:
    index, descriptor, alive = map(int, options.worker.split(","))
    listener = socket.socket(fileno=descriptor)

    def watch() -> None:
        os.read(alive, 1)
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=watch, daemon=True, name="watch").start()
    server = Server(
        options.data, public=public, listener=listener, stop_timeout_s=STOP_TIMEOUT_S, worker=index
    )
    return _serve(server, announce=False)
