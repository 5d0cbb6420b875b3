"""kill -9 of two processes under load: no acknowledged view is lost, and every start succeeds.

`CALIBDB_LOAD_KILLS` is the number of kills; 1 by default.
"""

import itertools
import os
import random
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.remote import Remote
from tests.helpers.service.rigs import RigTruth
from tests.helpers.stack.processes import LocalProcess

KILLS = int(os.environ.get("CALIBDB_LOAD_KILLS", "1"))
LEAST = 8
"""Acknowledged views before a kill."""


@dataclass
class Acknowledged:
    views: dict[str, int] = field(default_factory=dict)  # by session
    calibrations: dict[str, str] = field(default_factory=dict)  # by session

    def note(self, client: Client, state: Any) -> None:
        self.views[client.session_id] = len(state["views"])
        if state["calibration_id"] is not None:
            self.calibrations[client.session_id] = state["calibration_id"]


def capture(remote: Remote, heard: Acknowledged, seed: int) -> None:
    truth = Truth(seed=seed)
    for number in itertools.count():
        client = Client(remote)
        heard.note(client, client.open(**BRIEF, camera=f"Killed {seed}-{number}").json)
        while client.session_id not in heard.calibrations:
            heard.note(client, truth.show(client).json)


def capture_rigs(remote: Remote, heard: Acknowledged, seed: int) -> None:
    for number in itertools.count():
        rig = RigTruth(remote, seed=seed + number).open()
        for moment in ("a", "b", "c"):
            for position, answer in rig.moment(moment).items():
                heard.note(rig.clients[position], answer.json)


def until_killed(work: Callable[..., None], url: str, *more: Any) -> None:
    with suppress(httpx.TransportError), Remote(url) as remote:
        work(remote, *more)


def check(remote: Remote, heard: Acknowledged) -> None:
    for session, views in heard.views.items():
        client = Client(remote, session)
        state = client.state()
        assert len(state["views"]) >= views
        if session in heard.calibrations:
            assert state["calibration_id"] == heard.calibrations[session]
            assert client.calibration(state["calibration_id"]).status == 200


@pytest.mark.thorough
def test_nothing_acknowledged_is_lost(tmp_path: Path) -> None:
    data_dir, rng = tmp_path / "data", random.Random(5)
    everything = [Acknowledged()]
    for kill in range(KILLS):
        with (
            LocalProcess(data_dir, {"WORKERS": "2"}) as server,
            Remote(server.url) as remote,
            ThreadPoolExecutor(4) as pool,
        ):
            check(remote, everything[-1])
            heard = Acknowledged()
            everything.append(heard)
            running = [
                pool.submit(until_killed, work, server.url, heard, 10 * kill + n)
                for work, n in itertools.product((capture, capture_rigs), range(2))
            ]
            while sum(heard.views.values()) < LEAST:
                time.sleep(0.01)
                for each in running:
                    assert not each.done(), each.result()
            time.sleep(rng.uniform(0.0, 1.0))
            server.kill()
            for each in running:
                each.result(120)
    with LocalProcess(data_dir) as server, Remote(server.url) as remote:
        for heard in everything:
            check(remote, heard)
        assert "damaged" not in server.log.read_text()
