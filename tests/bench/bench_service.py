"""Handlers with all that they do, without a socket, storage in memory."""

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator

from calibdb import schema
from calibsolver.consensus import fit_memory
from infra.server.server import Server
from tests.bench.table import Row
from tests.helpers.data import ROOT
from tests.helpers.service.client import CAMERA, Client, Truth
from tests.helpers.service.published import PLATFORM, calibration, mode_of, publish, store


def rows() -> Iterator[Row]:
    with Server() as stack:
        client = Client(stack)
        # The session of `submit` starts from a known camera, and does not end at its tenth view.
        publish(stack, *(calibration(CAMERA["camera"], n) for n in range(5)), models=())
        yield submit(client)
        yield from computed_on_the_fly(stack, client)
    for function, budget in (("lookup", 400), ("submit", 1000)):
        yield Row(f"import of {function}'s handler", imports(function), budget, "ms", "fresh interpreter")


def computed_on_the_fly(stack: Server, client: Client) -> Iterator[Row]:
    """A model that is not stored, of a camera with ten calibrations: pooled while the caller waits."""
    at_rest, camera = store(stack), "Camera of ten calibrations"
    documents = [calibration(camera, n, views=8) for n in range(10)]
    publish(stack, *documents, models=())
    mode = mode_of(documents[0])
    for model in schema.DISTORTION_MODELS:
        times, worked = [], []
        for _ in range(5):
            (known,) = (c for c in at_rest.consensuses.at(mode) if c.distortion_model == model)
            at_rest.consensuses.drop(known)
            fit_memory.forget()
            start, begun = time.perf_counter(), time.process_time()
            answer = client.lookup(camera=camera, platform=PLATFORM, distortion_model=model)
            times.append((time.perf_counter() - start) * 1e3)
            worked.append((time.process_time() - begun) * 1e3)
            if answer.status != 200:
                raise RuntimeError(f"{model}: {answer.body!r}")
        note = f"10 calibrations of 8 views; {statistics.median(worked):.0f} ms of the processor"
        yield Row(f"lookup, {model} computed on the fly", statistics.median(times), 500, "ms", note)


def submit(client: Client) -> Row:
    """A tenth view of a session that does not end: taken back and sent again under the next index."""
    truth = Truth(seed=99)
    client.open(target_error=0.001)
    while len(client.state()["views"]) < 9:
        truth.show(client)
    times = []
    while len(times) < 20:
        pose = client.pose().json
        ids, points = truth.see(pose)
        start = time.perf_counter()
        answer = client.view(pose["index"], ids, points)
        taken = (time.perf_counter() - start) * 1e3
        if answer.json["accepted"]:
            times.append(taken)
            client.call("DELETE", f"/v1/session/views/{pose['index']}")
    return Row("submit handler, 10th view", statistics.median(times), 100, "ms")


def imports(function: str) -> float:
    """Median wall time in ms of importing the handler, in an interpreter of its own."""
    code = "from time import monotonic as t; a = t(); import functions.{0}.app; print((t() - a) * 1e3)"
    command = [sys.executable, "-c", code.format(function)]
    runs = [subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True) for _ in range(5)]
    return statistics.median(float(run.stdout) for run in runs)
