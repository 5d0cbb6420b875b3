"""A killed server loses nothing that it has acknowledged, and what it keeps is consistent."""

import stat
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import boto3
import httpx
import pytest

from infra.local import LocalStack
from tests.helpers.stack.processes import LocalProcess

TOKEN = {"authorization": "Bearer cdb_dev_local"}


@dataclass
class Ledger:
    """Answers that clients received."""

    started: dict[str, Any] = field(default_factory=dict)  # session id -> state
    forgotten: set[str] = field(default_factory=set)
    doubtful: set[str] = field(default_factory=set)  # asked to be forgotten, without an answer
    cut_off: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def acknowledged(self) -> int:
        return len(self.started) + len(self.forgotten)


def write_until_cut_off(url: str, ledger: Ledger, worker: int) -> None:
    with httpx.Client(base_url=url, timeout=60) as client:
        try:
            for number in range(10_000):
                session = client.post("/v1/auth", headers=TOKEN).json()["session_id"]
                credential = {"authorization": f"Bearer {session}"}
                body = {"camera": f"Camera {worker}-{number}", "platform": "Linux", "img_size": [1280, 720]}
                answer = client.post("/v1/session", headers=credential, json=body)
                assert answer.status_code == 201, answer.text
                with ledger.lock:
                    ledger.started[session] = answer.json()
                if number % 5 == 4:
                    ledger.doubtful.add(session)
                    assert client.delete("/v1/session", headers=credential).status_code == 204
                    with ledger.lock:
                        ledger.forgotten.add(session)
        except httpx.TransportError:
            with ledger.lock:
                ledger.cut_off += 1


def dangling_pointers(data_dir: Path) -> tuple[int, list[str]]:
    """Number of running sessions in the index, and those that point to no object."""
    with LocalStack(data_dir) as stack:
        table, bucket = stack.environment["TABLE_NAME"], stack.environment["BUCKET_NAME"]
        pages = boto3.client("dynamodb").get_paginator("scan").paginate(TableName=table)
        items = [item for page in pages for item in page["Items"]]
        listed = boto3.client("s3").get_paginator("list_objects_v2").paginate(Bucket=bucket)
        objects = {entry["Key"] for page in listed for entry in page.get("Contents", [])}
    pointers = [
        f"sessions/{item['pk']['S'].removeprefix('SESSION#')}/{item['version']['N']}.json"
        for item in items
        if item["pk"]["S"].startswith("SESSION#") and "forgotten" not in item
    ]
    return len(pointers), [pointer for pointer in pointers if pointer not in objects]


def test_kill_while_writing_loses_no_acknowledged_write(tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    ledger = Ledger()
    with LocalProcess(data_dir) as server, ThreadPoolExecutor(4) as pool:
        workers = [pool.submit(write_until_cut_off, server.url, ledger, worker) for worker in range(4)]
        while ledger.acknowledged < 150:
            time.sleep(0.005)
            for worker in workers:
                assert not worker.done(), worker.result()
        server.kill()
        for worker in workers:
            worker.result(120)
    assert ledger.cut_off == 4, "every client was in the middle of something"
    assert ledger.acknowledged >= 150
    assert len(ledger.forgotten) >= 15

    with LocalProcess(data_dir) as server, httpx.Client(base_url=server.url) as client:
        for session, state in ledger.started.items():
            found = client.get("/v1/session", headers={"authorization": f"Bearer {session}"})
            if session in ledger.forgotten:
                assert found.status_code == 404
            elif session not in ledger.doubtful or found.status_code != 404:
                assert (found.status_code, found.json()) == (200, state)
        assert server.stop() == 0

    running, dangling = dangling_pointers(data_dir)
    assert running >= len(ledger.started) - len(ledger.doubtful)
    assert dangling == []


def test_restart_keeps_sessions_and_excludes_a_second_process(tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    with LocalProcess(data_dir) as first, httpx.Client(base_url=first.url) as client:
        session = client.post("/v1/auth", headers=TOKEN).json()["session_id"]
        port = first.url.rpartition(":")[2]
        with pytest.raises(RuntimeError, match=r"journal\.sqlite is in use by another process"):
            LocalProcess(data_dir).__enter__()
        with pytest.raises(RuntimeError, match=f"port {port} cannot be used"):
            LocalProcess(tmp_path / "other", {"PORT": port}).__enter__()
        assert first.stop() == 0
    assert stat.S_IMODE((data_dir / "secrets.json").stat().st_mode) == 0o600
    secrets = (data_dir / "secrets.json").read_text()
    with LocalProcess(data_dir) as second:
        credential = {"authorization": f"Bearer {session}"}
        body = {"camera": "C", "platform": "Linux", "img_size": [640, 480]}
        assert httpx.post(f"{second.url}/v1/session", headers=credential, json=body).status_code == 201
        assert second.stop() == 0  # a request is logged after it is answered
        log = second.log.read_text()
    assert "cdb_dev_local" not in log
    assert not [secret for secret in secrets.split('"') if len(secret) >= 32 and secret in log]
    assert "POST /v1/session 201" in log


def test_full_disk_refuses_writes_and_serves_reads(tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    kept: dict[str, Any] = {}
    refused = 0
    # No file may grow beyond this: the operating system refuses the journal as a full disk would.
    with LocalProcess(data_dir, file_limit=300_000) as server, httpx.Client(base_url=server.url) as client:
        while refused < 3:
            session = client.post("/v1/auth", headers=TOKEN).json()["session_id"]
            credential = {"authorization": f"Bearer {session}"}
            body = {"camera": f"Camera {len(kept)} " + "x" * 200, "platform": "Linux", "img_size": [640, 480]}
            answer = client.post("/v1/session", headers=credential, json=body)
            if answer.status_code == 201:
                kept[session] = answer.json()
            else:
                assert answer.status_code == 503, answer.text
                assert answer.headers["content-type"] == "application/problem+json"
                refused += 1
        assert len(kept) > 10
        for session, state in kept.items():
            found = client.get("/v1/session", headers={"authorization": f"Bearer {session}"})
            assert (found.status_code, found.json()) == (200, state)
    with LocalProcess(data_dir) as server, httpx.Client(base_url=server.url) as client:
        for session, state in kept.items():
            found = client.get("/v1/session", headers={"authorization": f"Bearer {session}"})
            assert (found.status_code, found.json()) == (200, state)
    assert dangling_pointers(data_dir) == (len(kept), [])
