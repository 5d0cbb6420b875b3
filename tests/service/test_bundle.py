"""The offline file answers as a lookup does, or not at all."""

import itertools
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from calibdb.lookup import well_known_ids
from calibdb.settings import Thresholds
from infra.ops.bundle import BundleResult, bundle
from infra.ops.context import OpsContext
from infra.server.server import Server, variables_set
from tests.helpers.node import run_module
from tests.helpers.service import labels, published
from tests.helpers.service.client import Client
from tests.helpers.service.known import LENS, LINUX, calibration, consensus, fit
from tests.helpers.service.published import put

PLATFORMS = {
    "Linux": LINUX,
    "Firefox": "X11; Linux x86_64; rv:140.0",
    "Windows": "Windows NT 10.0; Win64; x64",
    "macOS": "Macintosh; Intel Mac OS X 10_15_7",
    "ChromeOS": "X11; CrOS x86_64 14541.0.0",
    "Android": "Linux; Android 14; Pixel 8",
    "K": "Linux; Android 10; K",
    "iOS": "iPhone; CPU iPhone OS 17_5 like Mac OS X",
}
SIZES = ((1280, 720), (640, 480), (960, 540), (1920, 1080), (720, 1280), (1000, 700))
FISHEYE = fit((1280, 720), 700.0, distortion=(-0.01, 0.02, 0.0, 0.0), model="fisheye")
#: of the labels, one in so many is asked for
STEP = 1 if os.environ.get("THOROUGH") else 3
PROGRAM = """
import { readFileSync } from "node:fs";
import { Bundle } from "./web/sdk/bundle.js";
const { data, requests } = JSON.parse(readFileSync(0, "utf8"));
const bundle = new Bundle(data);
console.log(JSON.stringify(requests.map(({ distortion_model: model, ...key }) => bundle.find(key, model))));
"""
Request = dict[str, Any]
Label = tuple[str, str]  # and platform


@dataclass(frozen=True)
class Both:
    """Requests, the answers of the service (None: a miss) and of the file, and the file's size."""

    asked: list[Request]
    served: list[Any]
    found: list[Any]
    written: BundleResult
    public: bool


def reported(source: str) -> list[Label]:
    rows = labels.rows(source)
    return [(row.label, PLATFORMS.get(row.system.partition("(")[0].partition("/")[0], LINUX)) for row in rows]


def fill(stack: Server, known: list[Label]) -> None:
    store = published.store(stack)
    seen = set()
    for number, (label, platform) in enumerate(known):
        if platform == PLATFORMS["iOS"] and number % 4:
            continue  # one camera in thirty languages
        document = calibration(label, platform, number=number)
        store.calibrations.publish(document)
        key = document.camera_key
        if key in seen:
            continue
        seen.add(key)
        whose = {"camera": label, "platform": platform}
        rng = np.random.default_rng(number)
        f, lens = rng.uniform(700, 1400), tuple(rng.normal(LENS, 0.003).tolist())
        put(store, consensus(fit((1280, 720), f, None, lens, uncertainty=0.1), **whose))
        if number % 4 == 1:
            put(store, consensus(fit((640, 360), f / 2, None, lens, uncertainty=0.1), **whose))
            put(store, consensus(fit((640, 480), f / 1.4, None, lens), **whose, zoom=100.0))
        if number % 4 == 2:
            put(store, consensus(FISHEYE, **whose))
        if number % 6 == 0:
            put(store, consensus(fit((640, 480), f / 1.5, None, lens), **whose, reason="too_few"))
        well_known_ids.refresh_well_known(store, key, Thresholds(min_contributors=1, contributor_period=0))


def requests(known: list[Label]) -> list[Request]:
    found = []
    elsewhere = itertools.cycle(PLATFORMS.values())
    for number, (label, own) in enumerate(known):
        bare = label.rpartition(" (")[0] or label
        found += [
            {"camera": name, "platform": platform, "img_size": [1280, 720]}
            for name, platform in ((label, next(elsewhere)), (bare, own), (bare, next(elsewhere)))
        ]
        asked = {"camera": label, "platform": own, "img_size": [1280, 720]}
        ways = [{"img_size": list(size)} for size in SIZES]
        ways += [{"zoom": 100}, {"distortion_model": "fisheye"}, {"resize_mode": "crop-and-scale"}]
        found += [asked | ways[(number + step) % len(ways)] for step in (0, 2, 4, 5)]
    found.append({"camera": "constructor", "platform": LINUX, "img_size": [1280, 720]})
    return [{"zoom": 0, "distortion_model": "rectilinear"} | each for each in found]


@pytest.fixture(scope="module", params=labels.SOURCES)
def filled(request: pytest.FixtureRequest) -> Iterator[tuple[Server, list[Label]]]:
    known = reported(request.param)[STEP - 1 :: STEP]
    with Server() as stack:
        fill(stack, known)
        yield stack, known


@pytest.fixture(
    scope="module",
    params=[pytest.param("1", id="at home", marks=pytest.mark.thorough), pytest.param("3", id="in public")],
)
def both(
    request: pytest.FixtureRequest,
    filled: tuple[Server, list[Label]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Both:
    stack, known = filled
    path = tmp_path_factory.mktemp("bundle") / "cameras.json"
    with variables_set({"MIN_CONTRIBUTORS": request.param}):
        environment = stack.environment | {"MIN_CONTRIBUTORS": request.param}
        written = bundle(OpsContext.of(environment, secret_known=True), path, max_cameras=500)
        asked, client = requests(known), Client(stack)
        answers = [client.lookup(**each, redirect=False) for each in asked]
    assert {answer.status for answer in answers} == {200, 404}
    served = [answer.json if answer.status == 200 else None for answer in answers]
    found = run_module(PROGRAM, sent={"data": json.loads(path.read_text()), "requests": asked})
    return Both(asked, served, found, written, request.param == "3")


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return one == pytest.approx(other, rel=1e-8, abs=1e-12)
    return bool(one == other)


def test_bundle_answers_as_the_service_or_not_at_all(both: Both) -> None:
    found_of_served = []
    for asked, served, found in zip(both.asked, both.served, both.found, strict=True):
        if served is not None:
            found_of_served.append(found)
        if found is None:
            continue
        assert served is not None, asked
        # what becomes of it at another size is worked out for usual sizes only
        if asked["img_size"] == [1000, 700]:
            assert found["adapted"] is None
            served |= {"relation": found["relation"], "adapted": None}
        assert same(found, served), (asked, served, found)
    answers = [found for found in found_of_served if found is not None]
    assert len(answers) > 200 / STEP
    # At home an iPhone's "Back Camera" is the one that is meant; in public nobody's, so no file has it.
    assert len(answers) / len(found_of_served) > (0.9 if both.public else 0.6)
    exact = [found["exact_size"] for found in answers]
    assert 0.1 < exact.count(False) / len(exact) < 0.9, "both are asked for"
    assert any(found["adapted"] for found in answers)


def test_bundled_camera_is_small(both: Both) -> None:
    cameras = len(both.written.cameras)
    assert cameras > 20
    assert both.written.compressed / cameras < 160
    assert both.written.compressed / both.written.calibrations < 100
    assert both.written.size / cameras < 1000
