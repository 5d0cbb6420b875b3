"""The whole loop: guided captures of known cameras, their consensus, and lookups that find it."""

import time
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest

from calibdb import schema
from infra.server.server import Server
from tests.bench.captures import main
from tests.helpers.service.client import CAMERA, TOKEN, Client, Truth
from tests.helpers.service.commands import run
from tests.helpers.service.published import calibration, publish


@pytest.fixture(scope="module", autouse=True)
def known(stack: Server) -> list[Any]:
    publish(stack, *(calibration(str(CAMERA["camera"]), n, views=5) for n in range(4)))
    before = Client(stack).lookup()
    state = Truth(seed=4).calibrate(Client(stack))
    stack.wait_until_idle(120)
    return [before, state, Client(stack).lookup()]


def test_capture_converges_near_the_truth(known: list[Any]) -> None:
    state = known[1]
    assert len(state["views"]) <= 8
    away = np.abs(state["calibration"]["camera_matrix"] - Truth().matrix)
    assert (away <= [[5, 0, 8], [0, 5, 8], [0, 0, 0]]).all()
    assert state["calibration"]["avg_reprojection_error"] < 0.4


def test_four_are_too_few_and_five_are_reliable(known: list[Any]) -> None:
    before, _, after = known
    assert (before.status, before.json["reason"], after.status) == (307, "too_few", 200)


def test_the_redirect_carries_the_whole_key(known: list[Any]) -> None:
    answer = known[0]
    url = urlsplit(answer.headers["location"])
    assert url.path == "/calibrate/"
    assert {name: values[0] for name, values in parse_qs(url.query).items()} == {
        "camera": "Test camera",
        "platform": "X11; Linux x86_64",
        "img_size": "1280x720",
        "zoom": "0",
        "distortion_model": "rectilinear",
    }
    assert answer.json["guidance_url"] == answer.headers["location"]


def test_reliable_lookup_returns_the_whole_document(known: list[Any]) -> None:
    answer = known[2].json
    assert list(answer) == [name for name in schema.LookupAnswer.model_fields if name != "estimate"]
    assert {name: answer[name] for name in CAMERA} == CAMERA
    assert (answer["calibrations"], answer["reliable"], answer["exact_size"]) == (5, True, True)
    assert abs(answer["camera_matrix"][0][0] - 950) < 1
    assert 0 < answer["uncertainty"]["rms"] <= answer["uncertainty"]["max"] < 0.3
    assert abs(answer["calibration_time"] - time.time()) < 600


def test_get_answers_like_post_and_may_be_cached_for_a_moment(client: Client) -> None:
    query = "camera=Test+camera&platform=X11;%20Linux%20x86_64&img_size=1280x720&zoom=0"
    answer = client.call("GET", "/v1/lookup", token="", query=f"{query}&key={TOKEN}")
    assert answer.json == client.lookup().json
    assert answer.headers["cache-control"] == "public, max-age=20"


def test_the_older_public_clients_spellings(client: Client) -> None:
    asked = {"camera": "Test camera", "userAgent": CAMERA["platform"], "imsize": [1280, 720]}
    answer = client.call("POST", "/v1/lookup", {**asked, "zoom": 0, "api_key": TOKEN}, token="")
    assert answer.json == client.lookup().json
    query = "camera=Test+camera&userAgent=X11;%20Linux%20x86_64&imsize=1280x720&api_key=cdb_dev_local"
    assert client.call("GET", "/v1/lookup", token="", query=query).json == answer.json


def test_answered_consensus_is_found_by_its_id(client: Client, known: list[Any]) -> None:
    for expected in (client.lookup().json, known[1]["calibration"]):
        found = client.calibration(expected["id"]).json
        of_both = expected.keys() & found.keys()
        assert of_both == schema.Calibration.model_fields.keys()
        assert {k: found[k] for k in of_both} == {k: expected[k] for k in of_both}
        assert client.calibration(expected["id"], "format=calibdb").json == found


def test_any_stack_can_be_driven(url: str) -> None:
    assert "1 captures in" in run(main, url, "--sessions", "1", "--clients", "1").out
    assert "403" in run(main, url, "--token", "cdb_no_token", "--sessions", "1", status=1).err
