"""Lookups through the gateway."""

from typing import Any

import pytest

from calibdb.camera_key import camera_key
from calibdb.lookup import camera_match, well_known_ids
from calibdb.settings import Thresholds
from calibdb.store import Store
from infra.server.server import Server, variables_set
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.known import C920, LINUX, calibration, consensus, fit
from tests.helpers.service.published import put
from tests.helpers.service.storage_calls import storage_calls

WINDOWS = "Windows NT 10.0; Win64; x64"
PUBLIC = {"MIN_CONTRIBUTORS": "3"}


def ask(stack: Server, camera: str, platform: str = LINUX, **asked: Any) -> Answer:
    return Client(stack).lookup(camera=camera, platform=platform, **asked)


@pytest.fixture(scope="module", autouse=True)
def known(stack: Server, store: Store) -> None:
    store.calibrations.publish(calibration())
    put(
        store,
        consensus(fit((1280, 720), uncertainty=0.1)),
        consensus(fit((640, 360), 475.0, uncertainty=0.1)),
        consensus(fit((1280, 720), 2000.0), zoom=3.0),
        consensus(fit((1280, 720), 1200.0), zoom=2.0),
        consensus(camera="Doubtful X1 (1111:0001)", reason="disagree"),
        consensus(
            fit(model="fisheye", distortion=(0.0,) * 4), camera="Doubtful X1 (1111:0001)", reason="too_few"
        ),
    )
    ask(stack, C920)  # the token is remembered from here on


@pytest.mark.parametrize("platform", [LINUX, WINDOWS])
def test_a_hit_is_one_query_and_no_write(stack: Server, platform: str) -> None:
    with storage_calls(stack) as asked:
        answer = ask(stack, C920, platform)
    assert answer.status == 200
    assert asked == ["Query"]
    facts = ("exact_size", "spread", "held_out_error", "basis", "relation", "adapted")
    assert [answer.json[name] for name in facts] == [True, 0.4, 0.3, "consensus", "scale", None]


def test_a_name_alone_takes_a_second_query(stack: Server) -> None:
    with storage_calls(stack) as asked:
        answer = ask(stack, "Logitech HD Pro Webcam C920", WINDOWS)
    assert (answer.status, answer.json["camera"]) == (200, C920)
    assert asked == ["Query", "Query"]


@pytest.mark.parametrize(
    ("camera", "options", "reason", "queries"),
    [
        ("Nobody's X9 (1111:0009)", {}, "unknown_camera", 2),
        ("Nobody's X9", {}, "unknown_camera", 1),
        ("Doubtful X1 (1111:0001)", {}, "disagree", 1),
        ("Doubtful X1 (1111:0001)", {"distortion_model": "fisheye"}, "too_few", 1),
        (C920, {"zoom": 4.0}, "unknown_camera", 1),
        (C920, {"resizeMode": "crop-and-scale"}, "unknown_camera", 0),
        ("OBS Virtual Camera", {}, "unknown_camera", 0),
    ],
)
def test_a_miss_says_why_and_computes_nothing(
    stack: Server, camera: str, options: dict[str, Any], reason: str, queries: int
) -> None:
    with storage_calls(stack) as asked:
        answer = ask(stack, camera, **options)
    assert asked == ["Query"] * queries
    assert answer.status == 307
    assert answer.json["reason"] == reason
    assert len(answer.json["detail"]) > 20
    assert answer.json["guidance_url"] == answer.headers["location"]
    refused = ask(stack, camera, **options, redirect=False)
    assert (refused.status, refused.json["reason"]) == (404, reason)
    assert refused.json["detail"] == answer.json["detail"]
    missed = ask(stack, camera, **options, miss="ok").json
    assert (missed["calibration"], missed["guidance_url"]) == (None, answer.json["guidance_url"])
    assert answer.json["estimate"] == refused.json["estimate"] == missed["estimate"]
    assert missed["estimate"]["hfov_deg"] > 0


def test_guidance_page_of_a_miss_by_get_is_not_cached(stack: Server) -> None:
    query = "camera=No+one%27s&platform=X11&img_size=1280x720&miss=ok"
    visited = Client(stack).call("GET", "/v1/lookup", query=query)
    assert (visited.status, visited.headers["cache-control"]) == (200, "no-store")
    assert "camera=No+one%27s&platform=X11" in visited.json["guidance_url"]


def test_a_size_between_two_that_scale(stack: Server) -> None:
    found = ask(stack, C920, img_size=[960, 540]).json
    assert (found["exact_size"], found["relation"]) == (False, "scale")
    assert found["adapted"]["img_size"] == [960, 540]
    assert found["adapted"]["camera_matrix"][0] == [pytest.approx(712.5), 0.0, pytest.approx(479.5)]
    assert ask(stack, C920, img_size=[1920, 1080]).json["adapted"] is None


def test_a_zoom_between_two(stack: Server) -> None:
    found = ask(stack, C920, zoom=2.5).json
    assert (found["zoom"], found["adapted"]["interpolated"]) == (2.5, True)
    assert found["camera_matrix"][0][0] == pytest.approx(1600.0)
    assert ask(stack, C920, zoom=2.0).json["adapted"] is None


def test_uncomputable_model_is_tried_once(stack: Server, store: Store) -> None:
    """A hostile client cannot make every lookup a computation: what came out is stored, be it nothing."""
    label = "Worthless X2 (1111:0002)"
    for number in range(5):
        store.calibrations.publish(calibration(label, number=number))
    put(store, consensus(camera=label))
    with storage_calls(stack) as asked:
        answer = ask(stack, label, distortion_model="fisheye")
    assert answer.status == 307
    assert asked.count("Invoke") == 1
    for _ in range(3):
        with storage_calls(stack) as asked:
            assert ask(stack, label, distortion_model="fisheye").status == 307
        assert asked == ["Query"]


def test_second_usb_id_makes_a_name_ambiguous(stack: Server, store: Store) -> None:
    name, rules = "Twofold X3", Thresholds(min_contributors=3, contributor_period=0)
    with variables_set(PUBLIC):
        for label, status in ((f"{name} (1111:0003)", 200), (f"{name} (1111:0004)", 307)):
            store.calibrations.publish(calibration(label))
            put(store, consensus(camera=label))
            well_known_ids.refresh_well_known(store, camera_key(label, LINUX), rules)
            answer = ask(stack, name)
            assert answer.status == status
        generic = ask(stack, "Integrated Camera")
    assert answer.json["detail"] == camera_match.SEVERAL
    assert generic.json["detail"] == camera_match.AMBIGUOUS, "at home one knows which is meant"
