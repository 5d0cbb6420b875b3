"""Slowest request of each endpoint that an adversarial generator finds: `make bench DOCS=slowest`.

Random scenarios at first; then, half of the time, changes of the slowest one found for an endpoint. The time
is that of the processor in the function, storage in memory included. `SECONDS=600` to search, `SEED=0`.
"""

import os
import random
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import SimpleNamespace as Scenario
from typing import Any
from unittest import mock

import numpy as np

from calibdb import schema
from tests.aws.emulator import LocalStack
from tests.aws.emulator.functions import Function
from tests.bench.document import table
from tests.helpers.service.client import CAMERA, TOKEN, Client, Truth
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store
from tests.helpers.service.rigs import MIN_SEEN, RigTruth

ORDINARY_S, EXTREME_S = 3.0, 6.0
"""Processor time allowed to a request with a board to 24 x 18 squares, and to any."""
BOARDS: tuple[tuple[tuple[int, int], str], ...] = (
    ((9, 6), "DICT_4X4_50"),
    ((14, 9), "DICT_4X4_250"),
    ((24, 18), "DICT_4X4_250"),
    ((36, 24), "DICT_4X4_1000"),
    ((50, 49), "DICT_APRILTAG_36h10"),
)
ORDINARY_BOARDS = 3
CHOICES: dict[str, tuple[Any, ...]] = {
    "kind": (*("capture",) * 5, *("check",) * 2, *("export",) * 5, "read", *("rig",) * 4),
    "board": (0, 0, 0, 1, 1, 2, 2, 2, 3, 4, 4),
    "model": schema.DISTORTION_MODELS,
    "guidance": (*("projection-uncertainty",) * 4, "pose-selection"),
    "honest": tuple(range(14)),
    "lies": (1, 2, 3, 4),
    "focal": (300.0, 700.0, 850.0, 920.0, 2000.0, 9000.0),
    "noise": (0.02, 0.2, 0.6, 2.0, 8.0),
    "wild": (0.0, 0.0, 0.1, 0.3),
    "undo": (False, False, True),
    "skip": (0, 1, 2),
    "format": schema.export.FORMATS,
    "crop": (
        "",
        "0,0,64,64",
        "1216,656,64,64",
        "0,0,1280,64",
        "0,0,64,720",
        "160,0,960,720",
        "600,300,64,96",
    ),
    "resize": ("", "64x64", "64x512", "512x64", "8192x8192", "16384x4096", "640x360"),
    "rotate": ("", "90", "180"),
    "subject": tuple(range(1 << 16)),
    "cameras": (2, 2, 3, 8, 8),
    "moments": (4, 6, 12, 30),
    "dense": (0, 0, 1),
    "baseline": (0.0, 0.6, 2.0),
}
"""Facts of a scenario. `wild`: share of corners anywhere in false views. `dense`: moments of a rig with whole
views, before others of 16 corners; 0: all are whole. `baseline`: squares between neighbours.
"""


def random_scenario(rng: random.Random) -> Scenario:
    return Scenario(**{name: rng.choice(values) for name, values in CHOICES.items()})


def changed(scenario: Scenario, rng: random.Random) -> Scenario:
    """Scenario of the same kind with some of its facts replaced."""
    other = {name: fact for name, fact in vars(random_scenario(rng)).items() if rng.random() < 0.25}
    return Scenario(**vars(scenario) | other | {"kind": scenario.kind})


@dataclass
class Slowest:
    """Slowest invocation so far of each route, with ordinary boards and others: s, status, scenario."""

    found: dict[tuple[str, bool], tuple[float, int, Scenario]] = field(default_factory=dict)
    count: Counter[str] = field(default_factory=Counter)
    statuses: Counter[int] = field(default_factory=Counter)
    current: Scenario = field(default_factory=Scenario)

    def note(self, route: str, seconds: float, status: int) -> None:
        self.count[route] += 1
        self.statuses[status] += 1
        key = route, self.current.board < ORDINARY_BOARDS
        if seconds > self.found.get(key, (0.0,))[0]:
            self.found[key] = seconds, status, self.current


@contextmanager
def measured(slowest: Slowest) -> Iterator[None]:
    """Measure every invocation of a function in the block."""
    invoke = Function.__call__

    def timed(self: Function, event: Any, request_id: str | None = None) -> Any:
        begun = time.thread_time()
        answer: Any = None
        try:
            answer = invoke(self, event, request_id)
            return answer
        finally:
            status = answer.get("statusCode", 0) if isinstance(answer, dict) else 0
            route = event.get("routeKey", self.spec.name) if isinstance(event, Mapping) else self.spec.name
            slowest.note(route, time.thread_time() - begun, status)

    with mock.patch.object(Function, "__call__", timed):
        yield


def board_of(scenario: Scenario) -> dict[str, Any]:
    squares, dictionary = BOARDS[scenario.board]
    return {"squares": list(squares), "dictionary": dictionary}


def false_truth(scenario: Scenario, **more: Any) -> Truth:
    squares, _ = BOARDS[scenario.board]
    return Truth(fx=scenario.focal, fy=scenario.focal, squares=squares, noise=scenario.noise, **more)


def capture(client: Client, scenario: Scenario) -> None:
    """Run a capture whose last views are of another camera."""
    opened = client.open(
        camera=f"Slow {scenario.subject}",
        board=board_of(scenario),
        distortion_model=scenario.model,
        guidance=scenario.guidance,
        target_error=0.001,
    )
    assert opened.status == 201, opened.body
    honest = Truth(squares=BOARDS[scenario.board][0], seed=scenario.subject, noise=0.2)
    liar = false_truth(scenario, seed=1)
    taken = 0
    for attempt in range(scenario.honest + scenario.lies + 6):
        pose = client.pose("skip=1" if attempt < scenario.skip else "")
        if pose.status != 200:
            break
        lies = taken >= scenario.honest
        seen = (liar if lies else honest).see(pose.json)
        answer = client.view(pose.json["index"], *spoiled(seen, scenario, lies))
        if answer.status != 200 or answer.json["status"] == "converged":
            break
        taken += lies or answer.json["accepted"]
        if taken >= scenario.honest + scenario.lies:
            break
    client.call("GET", "/v1/session/pose", headers={"accept": "image/png"})
    client.call("GET", "/v1/session")
    if scenario.undo:
        client.call("DELETE", "/v1/session/views/0")
    client.call("DELETE", "/v1/session")


def capture_rig(stack: LocalStack, scenario: Scenario) -> None:
    """Capture a rig in whose last moments camera 1 sees another board pose, or corners anywhere."""
    rig = RigTruth(
        stack,
        scenario.cameras,
        *BOARDS[scenario.board],
        scenario.baseline,
        min(scenario.noise, 0.6),
        scenario.subject,
        start={"distortion_model": scenario.model},
    ).open()
    for n in range(scenario.moments):
        if rig.call("POST", "/moments", {"moment": f"m{n}"}).status != 201:
            break
        pose, false = rig.held(), n >= scenario.moments - scenario.lies
        for position in range(scenario.cameras):
            seen = rig.see(position, rig.held() if false and position == 1 else pose)
            ids, points = spoiled(seen, scenario, false)
            few = slice(16) if scenario.dense and n >= scenario.dense else slice(None)
            if len(ids) >= MIN_SEEN:
                rig.view(position, f"m{n}", ids[few], points[few])
        if n in (1, 3, scenario.moments // 2):
            rig.call("GET")
    rig.call("GET", query="skip=1" if scenario.skip else "")
    for client in rig.clients[:2]:
        client.call("GET", "/v1/session/pose", headers={"accept": "image/png"})
    if scenario.undo:
        rig.call("DELETE", "/moments/m0")
    if rig.call("POST", "/finish").status == 200:
        for name in (scenario.format, "opencv_stereo", "kalibr", "colmap"):
            rig.result(name)
    else:
        rig.call("DELETE")


def spoiled(seen: tuple[list[int], list[list[float]]], scenario: Scenario, lies: bool) -> Any:
    """Put some corners of a false view anywhere."""
    ids, points = seen
    if lies and scenario.wild:
        rng = np.random.default_rng(scenario.subject)
        for n in np.flatnonzero(rng.uniform(size=len(points)) < scenario.wild):
            points[n] = [float(rng.uniform(0, 1279)), float(rng.uniform(0, 719))]
    return ids, points


def check(client: Client, scenario: Scenario, camera: str) -> None:
    board, truth = board_of(scenario), false_truth(scenario)
    client.authenticate()
    views = []
    for n in range(5):
        tilt = [0.5 * np.cos(n), 0.5 * np.sin(n), 0.1]
        far = [-truth.squares[0] / 2, -truth.squares[1] / 2, 1.2 * max(truth.squares) * scenario.focal / 950]
        ids, points = spoiled(truth.see({"rvec": tilt, "tvec": far}), scenario, True)
        views.append({"ids": ids, "points": points})
    body = {**CAMERA, "camera": camera, "platform": PLATFORM, "board": board, "views": views}
    client.call("POST", "/v1/checks", {**body, "distortion_model": scenario.model})


def export(client: Client, scenario: Scenario, ids: list[str]) -> None:
    number = scenario.subject % len(ids)
    names = (name for name in ("format", "crop", "resize", "rotate") if getattr(scenario, name))
    query = "&".join(f"{name}={getattr(scenario, name)}" for name in names)
    for more in ("", "&without=0") if number == 0 else ("",):
        client.call("GET", f"/v1/calibrations/{ids[number]}", token=TOKEN, query=query + more)


def search(seconds: float, seed: int) -> Slowest:
    rng, slowest = random.Random(seed), Slowest()
    with (
        mock.patch("tests.aws.emulator.stack.INTEGRATION_TIMEOUT_S", 600),
        LocalStack(environment={"MIN_CONTRIBUTORS": "1"}) as stack,
    ):
        for function in stack.functions.values():
            # Only processor time counts here, however busy the machine is.
            function.spec = replace(function.spec, timeout=600)
        client, camera = Client(stack), "Camera of exports"
        documents = [calibration(camera, n, views=6) for n in range(6)]
        for document in documents:
            store(stack).calibrations.publish(document)
        known = store(stack).refit.now(asked(mode_of(documents[0]))).models
        ids = [documents[0].id, *(c.calibration.id for c in known.values() if c and c.calibration)]
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            best = [scenario for _, _, scenario in slowest.found.values()]
            is_climbing = best and rng.random() < 0.5
            scenario = changed(rng.choice(best), rng) if is_climbing else random_scenario(rng)
            slowest.current = scenario
            with measured(slowest):
                if scenario.kind == "capture":
                    capture(client, scenario)
                elif scenario.kind == "rig":
                    capture_rig(stack, scenario)
                elif scenario.kind == "check":
                    check(client, scenario, camera)
                elif scenario.kind == "export":
                    export(client, scenario, ids)
                else:
                    client.lookup(camera=camera, platform=PLATFORM, distortion_model=scenario.model)
                    client.call("GET", "/v1/cameras", token=TOKEN, query="query=c")
                stack.wait_until_idle(600)
    return slowest


def main() -> int:
    slowest = search(float(os.environ.get("SECONDS", "600")), int(os.environ.get("SEED", "0")))
    rows, over, none = [], 0, (0.0, 0, Scenario())
    for route in sorted(slowest.count):
        ordinary = slowest.found.get((route, True), none)
        extreme = max(ordinary, slowest.found.get((route, False), none), key=lambda found: found[0])
        if route.startswith(("GET", "POST", "DELETE")):
            over += ordinary[0] > ORDINARY_S or extreme[0] > EXTREME_S
        facts = ", ".join(f"{name}={fact}" for name, fact in vars(extreme[2]).items())
        figures = f"{ordinary[0]:.2f}", f"{extreme[0]:.2f}", str(slowest.count[route])
        rows.append([f"`{route}`", *figures, f"{extreme[1]}: {facts}"])
    print(table(["request", "ordinary board, s", "any board, s", "requests", "the slowest one"], rows))
    print(f"\nstatuses: {dict(sorted(slowest.statuses.items()))}; over the budget: {over}")
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main())
