"""A killed server loses nothing that it has acknowledged, and what it keeps is consistent."""

import itertools
import logging
import resource
import signal
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest

from infra.server import folder
from infra.server.command import main
from infra.server.server import PortInUseError, Server
from tests.helpers.marks import thorough
from tests.helpers.service.client import TOKEN, Client
from tests.helpers.service.commands import run
from tests.helpers.service.published import asked, calibration, mode_of, store
from tests.helpers.service.remote import Remote
from tests.helpers.stack.processes import LocalProcess


@dataclass
class Ledger:
    """Answers that clients received."""

    started: dict[str, Any] = field(default_factory=dict)  # session id -> state
    forgotten: set[str] = field(default_factory=set)
    doubtful: set[str] = field(default_factory=set)  # asked to be forgotten, without an answer


def write_until_cut_off(url: str, ledger: Ledger, worker: int) -> None:
    with suppress(httpx.TransportError), Remote(url) as remote:
        for number in itertools.count():
            client = Client(remote)
            started = client.open(camera=f"Camera {worker}-{number}").json
            session = client.session_id
            ledger.started[session] = started
            if number % 5 == 4:
                ledger.doubtful.add(session)
                assert client.forget().status == 204
                ledger.forgotten.add(session)


def dangling_pointers(stack: Server) -> tuple[int, list[str]]:
    """Number of running sessions in the index, and those that point to no object."""
    table, objects = stack.storage.table, stack.storage.objects
    items = [item for key in table.keys("SESSION#") if (item := table.get(*key)) and "forgotten" not in item]
    pointers = [
        f"sessions/{str(item['pk']).removeprefix('SESSION#')}/{item.get('content', item['version'])}.json"
        for item in items
    ]
    return len(pointers), [pointer for pointer in pointers if objects.get(pointer) is None]


def test_kill_while_writing_loses_no_acknowledged_write(tmp_path: Path) -> None:
    ledger = Ledger()
    with LocalProcess(tmp_path / "data", {"WORKERS": "2"}) as server, ThreadPoolExecutor(4) as pool:
        workers = [pool.submit(write_until_cut_off, server.url, ledger, worker) for worker in range(4)]
        while len(ledger.started) + len(ledger.forgotten) < 60:
            time.sleep(0.005)
            for worker in workers:
                assert not worker.done(), worker.result()
        server.kill()
        for worker in workers:
            worker.result(120)
    with Server(tmp_path / "data") as stack:
        for session, state in ledger.started.items():
            found = Client(stack, session).call("GET", "/v1/session")
            if session in ledger.forgotten:
                assert found.status == 404
            elif session not in ledger.doubtful or found.status != 404:
                assert (found.status, found.json) == (200, state)
        running, dangling = dangling_pointers(stack)
    assert running >= len(ledger.started) - len(ledger.doubtful)
    assert dangling == []


def refusal(data_dir: Path) -> str:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(folder, "LOCK_TIMEOUT_S", 0.2)
        patch.setattr(logging.getLogger("infra"), "level", logging.INFO)  # what it sets passes
        return run(main, "--data", data_dir, "--port", "0", status=1).err


@pytest.mark.parametrize(
    ("number", "workers"),
    [
        (signal.SIGINT, "2"),
        *thorough((signal.SIGINT, "1"), (signal.SIGTERM, "2"), (signal.SIGTERM, "1")),
    ],
)
def test_server_stops_within_three_seconds_and_a_restart_keeps_its_sessions(
    tmp_path: Path, number: signal.Signals, workers: str
) -> None:
    data_dir = tmp_path / "data"
    with LocalProcess(data_dir, {"WORKERS": workers}) as first, Remote(first.url) as remote:
        client = Client(remote)
        state = client.open().json
        assert client.call("GET", "/v1/session", token="unknown-secret").status == 403
        port = int(first.url.rpartition(":")[2])
        assert "is in use by another server" in refusal(data_dir)
        with pytest.raises(PortInUseError, match=f"port {port} cannot be used"):
            Server(port=port).__enter__()
        with socket.create_connection(("127.0.0.1", port)) as slow:
            # Its body does not come: a server waits 30 s for it.
            slow.sendall(b"POST /v1/auth HTTP/1.1\r\nhost: localhost\r\ncontent-length: 9\r\n\r\n")
            begun = time.monotonic()
            first.process.send_signal(number)
            assert first.process.wait(20) == 0
            assert time.monotonic() - begun < 3 * 2, "s; twice that of a machine that does nothing else"
        log = first.log.read_text()
    secrets = (data_dir / "secrets.json").read_text()
    kept = [secret for secret in secrets.split('"') if len(secret) >= 32]
    for secret in (TOKEN, client.session_id, "unknown-secret", *kept):
        assert secret not in log
    assert "GET /v1/session 403" in log
    with Server(data_dir) as second:
        assert Client(second, client.session_id).state() == state


def test_clock_that_jumps_stops_neither_lookups_nor_jobs(tmp_path: Path) -> None:
    ahead = 0.0

    def clock() -> float:
        return time.time() + ahead

    label = "Camera of a machine without a battery"
    with Server(tmp_path / "data", environment={"MIN_CALIBRATIONS": "2"}, clock=clock) as stack:
        for jump in (0.0, 86_400.0, -86_400.0):
            for n in range(2):
                document = calibration(f"{label} {jump:.0f}", n)
                store(stack).calibrations.publish(document)
            store(stack).refit.later(asked(mode_of(document), "rectilinear"))
            ahead = jump  # the job is queued by now, and perhaps runs
            stack.wait_until_idle(60)
            assert Client(stack).lookup(camera=document.camera).status == 200


@contextmanager
def files_limited(size: int) -> Iterator[None]:
    """Let no file of this process grow beyond so many bytes: the write fails as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_full_disk_refuses_writes_and_serves_reads(tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    kept = {}
    refused = 0
    with Server(data_dir) as stack, files_limited(300_000):
        while refused < 3:
            client = Client(stack)
            answer = client.open(camera=f"Camera {len(kept)} " + "x" * 200)
            if answer.status == 201:
                kept[client.session_id] = answer.json
            else:
                assert answer.status == 503, answer
                refused += 1
        assert len(kept) > 10
        assert [Client(stack, session).state() for session in kept] == list(kept.values())
    with Server(data_dir) as stack:
        assert [Client(stack, session).state() for session in kept] == list(kept.values())
        assert dangling_pointers(stack) == (len(kept), [])
