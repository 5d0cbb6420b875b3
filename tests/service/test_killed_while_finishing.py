"""kill -9 while captures end: afterwards all of a calibration is there or nothing, and a retry completes it.

Two processes serve. `CALIBDB_KILLS` says the number of moments; 1 by default.
"""

import os
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from typing import Any

import httpx

from calibdb import schema
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Answer, Client, Truth
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import store
from tests.helpers.service.published import views as held_views
from tests.helpers.service.remote import Remote
from tests.helpers.stack.processes import LocalProcess

MOMENTS = int(os.environ.get("CALIBDB_KILLS", "1"))
#: captures that end when the server is killed: each is cut off at a moment of its own
AT_ONCE = min(6, MOMENTS)
KILLS = MOMENTS // AT_ONCE
Views = list[dict[str, Any]]


def begin(remote: Remote, views: Views, camera: str) -> str:
    client = Client(remote)
    client.open(camera=camera, **BRIEF)
    for view in views[:-1]:
        assert send(client, view).json["accepted"]
    return client.session_id


def send(client: Client, view: dict[str, Any]) -> Answer:
    return client.call("POST", "/v1/session/views", view)


def end_together(server: LocalProcess, sessions: list[str], last: dict[str, Any], kill_after: float) -> float:
    """Send all last views at once, kill the server so many seconds later; return how long they took."""
    ready = threading.Barrier(len(sessions) + 1)

    def end(session: str) -> None:
        with Remote(server.url) as remote:
            client = Client(remote, session)
            client.state()  # connected before it matters
            ready.wait()
            with suppress(httpx.TransportError):
                send(client, last)

    with ThreadPoolExecutor(len(sessions)) as pool:
        ended = [pool.submit(end, session) for session in sessions]
        ready.wait()
        started = time.monotonic()
        wait(ended, kill_after)
        if time.monotonic() - started >= kill_after:
            server.kill()
        wait(ended)
    return time.monotonic() - started


def published(operator: Operator) -> set[str]:
    """Ids of the calibrations in the bucket, in the index, and behind the consensus of every model."""
    with Server(operator.folder) as stack:
        stack.wait_until_idle(60)  # what was asked for is done
        table, objects = stack.storage.table, stack.storage.objects
        files = {name.rpartition("/")[2][:-5] for name in objects.names("calibrations/")}
        indexed = [sk.rpartition("#")[2] for _, sk in table.keys("CAMERA#") if sk.startswith("CALIBRATION#")]
        behind = {model: set() for model in schema.DISTORTION_MODELS}
        for key in {name.rpartition("-")[0] for name in files}:
            for consensus in store(stack).consensuses.of(key):
                for group in store(stack).consensuses.groups(consensus).groups:
                    behind[consensus.distortion_model] |= set(group)
    assert sorted(indexed) == sorted(files)
    assert all(members == files for members in behind.values()), "all or nothing"
    return files


def test_kill_while_finishing_is_completed_by_a_retry(operator: Operator) -> None:
    views = [{"index": n, **view} for n, view in enumerate(held_views(Truth(seed=3), 4))]
    rng = random.Random(7)
    cut = []
    files = set()
    window = 0.0
    for number in range(KILLS + 1):
        if cut:
            operator("reindex")
            files = published(operator)
        with LocalProcess(operator.folder, {"WORKERS": "2"}) as server, Remote(server.url) as remote:
            for client in (Client(remote, session) for session in cut):
                state = client.state()
                if state["status"] == "capturing":
                    assert len(state["views"]) == len(views) - 1
                else:
                    assert state["calibration_id"] in files
                retried = send(client, views[-1]).json
                assert (retried["status"], len(retried["views"])) == ("converged", len(views))
                assert send(client, views[-1]).json == retried
            if number == KILLS:
                server.stop()
                break
            if not window:  # how long it takes here and today
                undisturbed = [begin(remote, views, "Camera left alone") for _ in range(AT_ONCE)]
                window = 1.2 * end_together(server, undisturbed, views[-1], 30.0)
            cut = [begin(remote, views, f"Camera {number}") for _ in range(AT_ONCE)]
            # Random, and yet from all of the time that it takes.
            end_together(server, cut, views[-1], window * (number + rng.random()) / KILLS)
            server.kill()
    assert len(published(operator)) == (KILLS + 1) * AT_ONCE, "every capture once"
