"""Slowest request of each endpoint that an adversarial generator finds: `make bench DOCS=slowest`.

Random scenarios at first; then, half of the time, changes of the slowest one found for an endpoint. What is
measured is the processor time of the function that answers, storage in memory included, on this machine.
`SECONDS` (600) says how long to search, `SEED` where to begin.
"""

import os
import random
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any
from unittest import mock

import numpy as np

from calibdb import schema
from tests.aws.emulator import LocalStack
from tests.aws.emulator.functions import Function
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
KINDS = ("capture", "check", "export", "read", "rig")
CROPS = ("", "0,0,64,64", "1216,656,64,64", "0,0,1280,64", "0,0,64,720", "160,0,960,720", "600,300,64,96")
RESIZES = ("", "64x64", "64x512", "512x64", "8192x8192", "16384x4096", "640x360")


@dataclass(frozen=True)
class Scenario:
    """Requests of an attacker: captures that go wrong, alone or of a rig, a check, one export or read."""

    kind: str = "capture"
    board: int = 0
    model: str = "rectilinear"
    guidance: str = "projection-uncertainty"
    honest: int = 6
    lies: int = 2
    focal: float = 700.0
    noise: float = 0.2
    wild: float = 0.0
    undo: bool = False
    skip: int = 0
    query: str = ""
    subject: int = 0
    cameras: int = 2
    moments: int = 6
    dense: int = 0  # moments whose views are whole; the others have 16 corners. 0: all are
    baseline: float = 2.0  # squares between neighbours

    @property
    def is_ordinary(self) -> bool:
        """True if people have such a board."""
        return self.board < ORDINARY_BOARDS


def random_scenario(rng: random.Random) -> Scenario:
    query = f"format={rng.choice(schema.export.FORMATS)}"
    for name, values in (("crop", CROPS), ("resize", RESIZES), ("rotate", ("", "90", "180"))):
        if value := rng.choice(values):
            query += f"&{name}={value}"
    return Scenario(
        kind=rng.choices(KINDS, (5, 2, 5, 1, 4))[0],
        board=rng.choices(range(len(BOARDS)), (3, 2, 3, 1, 2))[0],
        model=rng.choice(schema.DISTORTION_MODELS),
        guidance=rng.choices(("projection-uncertainty", "pose-selection"), (4, 1))[0],
        honest=rng.randint(0, 13),
        lies=rng.randint(1, 4),
        focal=rng.choice((300.0, 700.0, 850.0, 920.0, 2000.0, 9000.0)),
        noise=rng.choice((0.02, 0.2, 0.6, 2.0, 8.0)),
        wild=rng.choice((0.0, 0.0, 0.1, 0.3)),
        undo=rng.random() < 0.3,
        skip=rng.randint(0, 2),
        query=query,
        subject=rng.randrange(1 << 16),
        cameras=rng.choice((2, 2, 3, 8, 8)),
        moments=rng.choice((4, 6, 12, 30)),
        dense=rng.choice((0, 0, 1)),
        baseline=rng.choice((0.0, 0.6, 2.0)),
    )


def changed(scenario: Scenario, rng: random.Random) -> Scenario:
    """The scenario with some of its members replaced."""
    other = random_scenario(rng)
    names = [name for name in scenario.__dataclass_fields__ if name != "kind" and rng.random() < 0.25]
    return replace(scenario, **{name: getattr(other, name) for name in names})


@dataclass
class Slowest:
    """The slowest invocation of each route so far."""

    found: dict[tuple[str, bool], tuple[float, int, Scenario]] = field(default_factory=dict)
    count: dict[str, int] = field(default_factory=dict)
    statuses: dict[int, int] = field(default_factory=dict)
    current: Scenario = Scenario()

    def note(self, route: str, seconds: float, status: int) -> None:
        self.count[route] = self.count.get(route, 0) + 1
        self.statuses[status] = self.statuses.get(status, 0) + 1
        key = (route, self.current.is_ordinary)
        if seconds > self.found.get(key, (0.0,))[0]:
            self.found[key] = seconds, status, self.current


@contextmanager
def measured(slowest: Slowest) -> Iterator[None]:
    """Have every invocation of a function measured, whoever makes it."""
    invoke = Function.__call__

    def timed(self: Function, event: Any, request_id: str | None = None) -> Any:
        begun = time.thread_time()
        status = 0
        try:
            answer = invoke(self, event, request_id)
            status = answer.get("statusCode", 0) if isinstance(answer, dict) else 0
            return answer
        finally:
            route = event.get("routeKey", self.spec.name) if isinstance(event, Mapping) else self.spec.name
            slowest.note(route, time.thread_time() - begun, status)

    Function.__call__ = timed  # type: ignore[method-assign]
    try:
        yield
    finally:
        Function.__call__ = invoke  # type: ignore[method-assign]


def capture(client: Client, scenario: Scenario) -> None:
    squares, dictionary = BOARDS[scenario.board]
    board = {"squares": list(squares), "dictionary": dictionary}
    start = {"distortion_model": scenario.model, "guidance": scenario.guidance, "target_error": 0.001}
    camera = f"Slow {scenario.subject}"
    opened = client.open(camera=camera, board=board, **start)
    assert opened.status == 201, opened.body
    honest = Truth(squares=squares, seed=scenario.subject, noise=0.2)
    liar = Truth(fx=scenario.focal, fy=scenario.focal, squares=squares, noise=scenario.noise, seed=1)
    taken = 0
    for attempt in range(scenario.honest + scenario.lies + 6):
        pose = client.pose("skip=1" if attempt < scenario.skip else "")
        if pose.status != 200:
            break
        lies = taken >= scenario.honest
        answer = client.view(
            pose.json["index"], *spoiled((liar if lies else honest).see(pose.json), scenario, lies)
        )
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
    squares, dictionary = BOARDS[scenario.board]
    start = {"distortion_model": scenario.model}
    noise = min(scenario.noise, 0.6)
    rig = RigTruth(
        stack, scenario.cameras, squares, dictionary, scenario.baseline, noise, scenario.subject, start=start
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
        rig.result(scenario.query.partition("&")[0].removeprefix("format="))
        for name in ("opencv_stereo", "kalibr", "colmap"):
            rig.result(name)
    else:
        rig.call("DELETE")


def spoiled(seen: tuple[list[int], list[list[float]]], scenario: Scenario, lies: bool) -> Any:
    """Views of a liar with some corners anywhere."""
    ids, points = seen
    if lies and scenario.wild:
        rng = np.random.default_rng(scenario.subject)
        for n in np.flatnonzero(rng.uniform(size=len(points)) < scenario.wild):
            points[n] = [float(rng.uniform(0, 1279)), float(rng.uniform(0, 719))]
    return ids, points


def check(client: Client, scenario: Scenario, camera: str) -> None:
    squares, dictionary = BOARDS[scenario.board]
    truth = Truth(fx=scenario.focal, fy=scenario.focal, squares=squares, noise=scenario.noise)
    client.session_id = client.call("POST", "/v1/auth", token=TOKEN).json["session_id"]
    views = []
    for n in range(5):
        tilt = [0.5 * np.cos(n), 0.5 * np.sin(n), 0.1]
        far = [-squares[0] / 2, -squares[1] / 2, 1.2 * max(squares) * scenario.focal / 950]
        ids, points = spoiled(truth.see({"rvec": tilt, "tvec": far}), scenario, True)
        views.append({"ids": ids, "points": points})
    board = {"squares": list(squares), "dictionary": dictionary}
    body = {**CAMERA, "camera": camera, "platform": PLATFORM, "board": board, "views": views}
    client.call("POST", "/v1/checks", {**body, "distortion_model": scenario.model})


def search(seconds: float, seed: int) -> Slowest:
    rng, slowest = random.Random(seed), Slowest()
    with (
        mock.patch("tests.aws.emulator.stack.INTEGRATION_TIMEOUT_S", 600),
        LocalStack(environment={"MIN_CONTRIBUTORS": "1"}) as stack,
        measured(slowest),
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
            climbing = best and rng.random() < 0.5
            scenario = changed(rng.choice(best), rng) if climbing else random_scenario(rng)
            slowest.current = scenario
            if scenario.kind == "capture":
                capture(client, scenario)
            elif scenario.kind == "rig":
                capture_rig(stack, scenario)
            elif scenario.kind == "check":
                check(client, scenario, camera)
            elif scenario.kind == "export":
                path = f"/v1/calibrations/{ids[scenario.subject % len(ids)]}"
                client.call("GET", path, token=TOKEN, query=scenario.query)
                if scenario.subject % len(ids) == 0:
                    client.call("GET", path, token=TOKEN, query=f"{scenario.query}&without=0")
            else:
                client.lookup(camera=camera, platform=PLATFORM, distortion_model=scenario.model)
                client.call("GET", "/v1/cameras", token=TOKEN, query="query=c")
            stack.wait_until_idle(600)
    return slowest


def main() -> int:
    slowest = search(float(os.environ.get("SECONDS", "600")), int(os.environ.get("SEED", "0")))
    print(
        "| request | ordinary board, s | any board, s | requests | the slowest one |\n|---|---|---|---|---|"
    )
    over = 0
    for route in sorted(slowest.count):
        ordinary = slowest.found.get((route, True), (0.0, 0, Scenario()))
        extreme = max(ordinary, slowest.found.get((route, False), (0.0, 0, Scenario())), key=lambda x: x[0])
        if route.startswith(("GET", "POST", "DELETE")):
            over += ordinary[0] > ORDINARY_S or extreme[0] > EXTREME_S
        said = ", ".join(f"{k}={v}" for k, v in vars(extreme[2]).items() if v != getattr(Scenario(), k))
        print(
            f"| `{route}` | {ordinary[0]:.2f} | {extreme[0]:.2f} | {slowest.count[route]} "
            f"| {extreme[1]}: {said.replace('|', ' ')} |"
        )
    print(f"\nstatuses: {dict(sorted(slowest.statuses.items()))}; over the budget: {over}")
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main())
