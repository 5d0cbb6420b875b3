"""kill -9 of two processes under load: nothing acknowledged is lost, and every start succeeds.

`CALIBDB_LOAD_KILLS` is the number of kills; 1 by default.
"""

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
from tests.helpers.service.rigs import MIN_SEEN, RigTruth
from tests.helpers.stack.processes import LocalProcess
from tests.service.test_durability import rotate_until_cut_off

KILLS = int(os.environ.get("CALIBDB_LOAD_KILLS", "1"))
LEAST = 8
"""Acknowledged writes before a kill."""


@dataclass
class Acknowledged:
    views: dict[str, int] = field(default_factory=dict)  # by session
    calibrations: dict[str, str] = field(default_factory=dict)  # by session
    moments: dict[tuple[str, str], set[str]] = field(default_factory=dict)  # by rig and its leader's session
    tokens: list[dict[str, Any]] = field(default_factory=lambda: [{}, {}])

    def count(self) -> int:
        secrets = sum(token.get("secrets", 0) for token in self.tokens)
        return sum(self.views.values()) + sum(map(len, self.moments.values())) + secrets

    def note(self, session: str, state: Any) -> None:
        self.views[session] = len(state["views"])
        if state["calibration_id"] is not None:
            self.calibrations[session] = state["calibration_id"]


def capture(remote: Remote, heard: Acknowledged, seed: int) -> None:
    truth = Truth(seed=seed)
    for number in range(1000):
        client = Client(remote)
        started = client.open(**BRIEF, camera=f"Killed {seed}-{number}").json
        heard.note(client.session_id, started)
        while client.session_id not in heard.calibrations:
            pose = client.pose().json
            heard.note(client.session_id, client.view(pose["index"], *truth.see(pose)).json)


def capture_rigs(remote: Remote, heard: Acknowledged, seed: int) -> None:
    for number in range(1000):
        rig = RigTruth(remote, seed=seed + number).open()
        moments = heard.moments[rig.rig_id, rig.clients[0].session_id] = set()
        for moment in ("a", "b", "c"):
            assert rig.call("POST", "/moments", {"moment": moment}).status == 201
            pose = rig.held()
            seen = [rig.see(position, pose) for position in range(rig.count)]
            views = [rig.view(position, moment, *points) for position, points in enumerate(seen)]
            if all(len(ids) >= MIN_SEEN for ids, _ in seen) and all(v.json["accepted"] for v in views):
                moments.add(moment)


def rotate(remote: Remote, token: dict[str, Any]) -> None:
    rotate_until_cut_off(str(remote.http.base_url), token, used=True)


def until_killed(work: Callable[..., None], url: str, *more: Any) -> None:
    with suppress(httpx.TransportError), Remote(url) as remote:
        work(remote, *more)


def check(remote: Remote, heard: Acknowledged) -> None:
    client = Client(remote)
    for session, views in heard.views.items():
        state = Client(remote, session).state()
        assert len(state["views"]) >= views
        if session in heard.calibrations:
            assert state["calibration_id"] == heard.calibrations[session]
    for name in heard.calibrations.values():
        assert client.calibration(name).status == 200
    for (rig, leader), moments in heard.moments.items():
        state = Client(remote, leader).call("GET", f"/v1/rigs/{rig}").json
        assert {moment["id"] for moment in state["moments"]} >= moments
    for token in filter(None, heard.tokens):
        assert client.call("GET", "/v1/usage", token=token["token"]).status == 200
        name = client.call("GET", "/v1/tokens/self", token=token["managing"]).json["name"]
        assert int(name or 0) - int(token.get("name", 0)) in (0, 1)


@pytest.mark.thorough
def test_nothing_acknowledged_is_lost(tmp_path: Path) -> None:
    data_dir, rng = tmp_path / "data", random.Random(5)
    environment = {"WORKERS": "2", "NEW_TOKENS": "1000"}
    everything, heard = list[Acknowledged](), Acknowledged()
    for kill in range(KILLS):
        with (
            LocalProcess(data_dir, environment) as server,
            Remote(server.url) as remote,
            ThreadPoolExecutor(6) as pool,
        ):
            check(remote, heard)
            heard = Acknowledged()
            everything.append(heard)
            seeds = range(10 * kill, 10 * kill + 2)
            running = [pool.submit(until_killed, capture, server.url, heard, seed) for seed in seeds]
            running += [pool.submit(until_killed, capture_rigs, server.url, heard, seed) for seed in seeds]
            running += [pool.submit(until_killed, rotate, server.url, token) for token in heard.tokens]
            while heard.count() < LEAST:
                time.sleep(0.01)
                for each in running:
                    assert not each.done(), each.result()
            time.sleep(rng.uniform(0.0, 1.0))
            server.kill()
            for each in running:
                each.result(120)
    with LocalProcess(data_dir, environment) as server, Remote(server.url) as remote:
        for heard in everything:
            check(remote, heard)
        assert "damaged" not in server.log.read_text()
    written = sum(heard.count() for heard in everything)
    print(f"{KILLS} kills under load: {written} acknowledged writes, none lost")
