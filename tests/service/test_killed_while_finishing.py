"""kill -9 while captures end: afterwards all of a calibration is there or nothing, and a retry completes it.

`CALIBDB_KILLS` says the number of moments; 1 by default.
"""

import os
import random
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import httpx
import pytest

from calibdb import schema
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, CAMERA, TOKEN, Client, Truth
from tests.helpers.service.published import store
from tests.helpers.stack.processes import LocalProcess
from tests.service.test_durability import bearer

MOMENTS = int(os.environ.get("CALIBDB_KILLS", "1"))
#: captures that end when the server is killed: each is cut off at a moment of its own
AT_ONCE = min(6, MOMENTS)
KILLS = MOMENTS // AT_ONCE
Views = list[dict[str, Any]]


def capture() -> Views:
    views: Views = []
    with Server() as stack:
        client, truth = Client(stack), Truth(seed=3)
        client.open(**BRIEF)
        while True:
            pose = client.pose().json
            ids, points = truth.see(pose)
            answer = client.view(pose["index"], ids, points).json
            if answer["accepted"]:
                views.append({"index": pose["index"], "ids": ids, "points": points})
            if answer["status"] == "converged":
                return views


def begin(client: httpx.Client, views: Views, camera: str) -> str:
    session = str(client.post("/v1/auth", headers=bearer(TOKEN)).json()["session_id"])
    assert send(client, session, "/v1/session", {**CAMERA, **BRIEF, "camera": camera}).status_code == 201
    for view in views[:-1]:
        answer = send(client, session, "/v1/session/views", view)
        assert answer.json()["accepted"], answer.text
    return session


def send(client: httpx.Client, session: str, path: str, body: dict[str, Any]) -> httpx.Response:
    return client.post(path, headers=bearer(session), json=body)


def end_together(server: LocalProcess, sessions: list[str], last: dict[str, Any], kill_after: float) -> float:
    """Send all last views at once, kill the server so many seconds later; return how long they took."""
    ready = threading.Barrier(len(sessions) + 1)

    def end(session: str) -> None:
        with httpx.Client(base_url=server.url, timeout=60) as client:
            client.get("/healthz")  # connected before it matters
            ready.wait()
            with suppress(httpx.TransportError):
                send(client, session, "/v1/session/views", last)

    with ThreadPoolExecutor(len(sessions)) as pool:
        ended = [pool.submit(end, session) for session in sessions]
        ready.wait()
        started = time.monotonic()
        wait(ended, kill_after)
        if time.monotonic() - started >= kill_after:
            server.kill()
        wait(ended)
    return time.monotonic() - started


def at_rest(data_dir: Path) -> tuple[set[str], set[str], set[str]]:
    """Ids of the calibrations in the bucket, in the index, and behind the consensus of every model."""
    with Server(data_dir) as stack:
        stack.wait_until_idle(60)  # what was asked for is done
        table, objects = stack.storage.table, stack.storage.objects
        files = {name.rpartition("/")[2][:-5] for name in objects.names("calibrations/")}
        indexed = [sk.rpartition("#")[2] for _, sk in table.keys("CAMERA#") if sk.startswith("CALIBRATION#")]
        known = {name.rpartition("-")[0] for name in files}
        consensuses = [c for key in known for c in store(stack).consensuses.of(key)]
        groups = [(c.distortion_model, store(stack).consensuses.groups(c)) for c in consensuses]
    behind: dict[str, set[str]] = {model: set() for model in schema.DISTORTION_MODELS}
    for model, found in groups:
        behind[model] |= {i for group in found.groups for i in group} if found else set()
    (members,) = {frozenset(ids) for ids in behind.values()}
    assert len(indexed) == len(set(indexed))
    return files, set(indexed), set(members)


def test_kill_while_finishing_is_completed_by_a_retry(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data_dir, views = tmp_path / "data", capture()
    monkeypatch.setenv("DATA_DIR", str(data_dir))
    rng = random.Random(7)
    cut: list[str] = []
    window = 0.0
    outcomes: Counter[str] = Counter()
    for number in range(KILLS + 1):
        if cut:
            assert main(["reindex"]) == 0
            files, indexed, behind = at_rest(data_dir)
            assert files == indexed == behind, "in the bucket, in the index, in the consensus: all or nothing"
        with ExitStack() as opened:
            if number < KILLS:
                server = opened.enter_context(LocalProcess(data_dir))
                url = server.url
            else:  # it is killed no more
                url = opened.enter_context(opened.enter_context(Server(data_dir)).serve())
            client = opened.enter_context(httpx.Client(base_url=url, timeout=60))
            for session in cut:
                state = client.get("/v1/session", headers=bearer(session)).json()
                outcomes[state["status"]] += 1
                if state["status"] == "capturing":
                    assert len(state["views"]) == len(views) - 1
                else:
                    assert state["calibration_id"] in files
                retried = send(client, session, "/v1/session/views", views[-1]).json()
                assert (retried["status"], len(retried["views"])) == ("converged", len(views))
                again = send(client, session, "/v1/session/views", views[-1]).json()
                assert again == retried
            if number == KILLS:
                break
            if not window:  # how long it takes here and today
                undisturbed = [begin(client, views, "Camera left alone") for _ in range(AT_ONCE)]
                window = 1.2 * end_together(server, undisturbed, views[-1], 30.0)
            cut = [begin(client, views, f"Camera {number}") for _ in range(AT_ONCE)]
            # Random, and yet from all of the time that it takes.
            end_together(server, cut, views[-1], window * (number + rng.random()) / KILLS)
            server.kill()
    files, indexed, behind = at_rest(data_dir)
    assert files == indexed == behind
    assert sum(outcomes.values()) == KILLS * AT_ONCE
    assert len(files) == (KILLS + 1) * AT_ONCE, "every capture once"
