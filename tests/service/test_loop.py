"""The whole loop: guided captures of known cameras, their consensus, and lookups that find it."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import parse_qs, urlsplit

import cv2
import numpy as np
import pytest

from calibdb import schema
from calibdb.settings import Settings
from calibdb.store import Store
from infra.server.server import Server
from tests.helpers.data import available, corner_set
from tests.helpers.marks import thorough
from tests.helpers.service.client import BRIEF, CAMERA, TOKEN, Client, Truth, until
from tests.helpers.service.storage_calls import storage_calls


def published(stack: Server, calibration_id: str, total: int) -> None:
    """Wait until the consensuses of the calibration's camera rest on `total` calibrations."""
    store = Store.of(Settings.from_environment(stack.environment))
    key = calibration_id.rpartition("-")[0]

    def counted() -> bool:
        known = store.consensuses.of(key)
        return {c.distortion_model for c in known if c.total >= total} == set(schema.DISTORTION_MODELS)

    until(counted)


@pytest.fixture(scope="module")
def known(stack: Server) -> list[Any]:
    """The camera of `CAMERA`, after five captures; what lookups said after each is kept."""
    history = []
    for n in range(5):
        state = Truth(seed=n).calibrate(Client(stack))
        published(stack, state["calibration_id"], n + 1)
        history.append((state, Client(stack).lookup()))
    return history


def test_every_capture_converges_near_the_truth(known: list[Any]) -> None:
    for state, _ in known:
        assert len(state["views"]) <= 8
        (fx, _, cx), (_, fy, cy), _ = state["calibration"]["camera_matrix"]
        assert abs(fx / 950 - 1) < 0.005
        assert abs(fy / 948 - 1) < 0.005
        assert abs(cx - 652) < 8
        assert abs(cy - 351) < 8
        assert state["calibration"]["avg_reprojection_error"] < 0.4


def test_four_are_too_few_and_five_are_reliable(known: list[Any]) -> None:
    assert [answer.status for _, answer in known] == [307, 307, 307, 307, 200]
    assert {answer.json["reason"] for _, answer in known[:4]} == {"too_few"}


def test_the_redirect_carries_the_whole_key(known: list[Any]) -> None:
    answer = known[3][1]
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
    answer = known[4][1].json
    assert list(answer) == [name for name in schema.LookupAnswer.model_fields if name != "estimate"]
    assert {name: answer[name] for name in CAMERA} == CAMERA
    assert (answer["calibrations"], answer["contributors"]) == (5, 1)
    assert answer["reliable"] is True
    assert answer["exact_size"] is True
    assert len(answer["distortion_coefficients"]) == 5
    assert abs(answer["camera_matrix"][0][0] - 950) < 1
    assert 0 < answer["uncertainty"]["rms"] <= answer["uncertainty"]["max"] < 0.3
    assert abs(answer["calibration_time"] - time.time()) < 600


@pytest.mark.usefixtures("known")
class TestLookup:
    def test_a_hit_is_one_query_and_nothing_else(self, stack: Server, client: Client) -> None:
        with storage_calls(stack) as asked:
            assert client.lookup().status == 200
            assert client.lookup(img_size=[640, 360]).status == 200
        assert asked == ["Query", "Query"]

    def test_a_consensus_with_nothing_new_is_not_computed_again(
        self, stack: Server, known: list[Any]
    ) -> None:
        store = Store.of(Settings.from_environment(stack.environment))
        key = known[-1][0]["calibration_id"].rpartition("-")[0]
        asked_for = schema.RefitRequest(
            camera=key, img_size=(1280, 720), zoom=0.0, models=schema.DISTORTION_MODELS
        )
        first = store.refit.now(asked_for)
        with storage_calls(stack) as asked:
            assert store.refit.now(asked_for) == first
        assert asked == ["Query"] * 3, "neither keypoints read nor anything written"

    def test_get_answers_like_post_and_may_be_cached_for_a_moment(self, client: Client) -> None:
        query = "camera=Test+camera&platform=X11;%20Linux%20x86_64&img_size=1280x720&zoom=0"
        answer = client.call("GET", "/v1/lookup", token="", query=f"{query}&key={TOKEN}")
        assert answer.json == client.lookup().json
        assert answer.headers["cache-control"] == "public, max-age=20"

    def test_the_older_public_clients_spellings(self, client: Client) -> None:
        asked = {"camera": "Test camera", "userAgent": CAMERA["platform"], "imsize": [1280, 720]}
        answer = client.call("POST", "/v1/lookup", {**asked, "zoom": 0, "api_key": TOKEN}, token="")
        assert answer.json == client.lookup().json
        query = "camera=Test+camera&userAgent=X11;%20Linux%20x86_64&imsize=1280x720&api_key=cdb_dev_local"
        assert client.call("GET", "/v1/lookup", token="", query=query).json == answer.json

    def test_a_whole_user_agent_is_reduced_to_its_platform(self, client: Client) -> None:
        agent = "Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0.0.0"
        assert client.lookup(platform=agent).status == 200

    @pytest.mark.parametrize("img_size", [[640, 360], [1920, 1080], [640, 480]])
    def test_another_resolution_is_answered_with_the_closest(
        self, client: Client, img_size: list[int]
    ) -> None:
        answer = client.lookup(img_size=img_size)
        assert answer.status == 200
        assert answer.json["exact_size"] is False
        assert answer.json["img_size"] == [1280, 720]

    def test_another_zoom_is_another_lens(self, client: Client) -> None:
        assert client.lookup(zoom=2).status == 307

    def test_another_camera_is_unknown(self, client: Client) -> None:
        for asked in ({"camera": "Another camera"}, {"platform": "Macintosh; Intel Mac OS X 10_15_7"}):
            answer = client.lookup(**asked)
            assert (answer.status, answer.json["reason"]) == (307, "unknown_camera")

    def test_without_redirect_the_body_has_the_url(self, client: Client) -> None:
        unknown = {**CAMERA, "camera": "Another camera"}
        for body, query in ((unknown, "redirect=false"), ({**unknown, "redirect": False}, "")):
            answer = client.call("POST", "/v1/lookup", body, token=TOKEN, query=query)
            assert answer.status == 404
            assert "/calibrate/?camera=Another+camera&" in answer.json["guidance_url"]
            assert answer.json["reason"] == "unknown_camera"
        assert client.call("POST", "/v1/lookup", CAMERA, token=TOKEN, query="redirect=false").status == 200

    def test_a_fisheye_fit_of_rectilinear_sessions(self, client: Client) -> None:
        answer = client.lookup(distortion_model="fisheye")
        assert answer.status == 200
        assert answer.json["distortion_model"] == "fisheye"
        assert len(answer.json["distortion_coefficients"]) == 4
        assert answer.json["avg_reprojection_error"] < 0.4

    def test_missing_model_is_computed_from_keypoints(self, stack: Server, client: Client) -> None:
        before = client.lookup(distortion_model="fisheye").json
        key = before["id"].partition("~")[0]
        place = f"CAMERA#{key}", "CONSENSUS#1280x720#0#fisheye"
        stack.storage.table.delete(*place)
        answer = client.lookup(distortion_model="fisheye", img_size=[640, 360])
        assert answer.status == 200
        assert answer.json == {**before, "exact_size": False}
        assert stack.storage.table.get(*place) is not None

    def test_answered_consensus_is_found_by_its_id(self, client: Client, known: list[Any]) -> None:
        consensus = client.lookup().json
        calibration = known[0][0]["calibration"]
        for expected in (consensus, calibration):
            path = f"/v1/calibrations/{expected['id']}"
            found = client.call("GET", path, token=TOKEN).json
            of_both = expected.keys() & found.keys()
            assert of_both == schema.Calibration.model_fields.keys()
            assert {k: found[k] for k in of_both} == {k: expected[k] for k in of_both}
            assert client.call("GET", path, token=TOKEN, query="format=calibdb").json == found

    def test_stored_calibration_has_keypoints_and_no_address(self, stack: Server, known: list[Any]) -> None:
        calibration = known[0][0]["calibration_id"]
        name = f"calibrations/{calibration.rpartition('-')[0]}/{calibration}.json"
        document = json.loads(stack.storage.objects.get(name) or b"")
        assert len(document["contributor"]) == 64
        assert "127.0.0.1" not in json.dumps(document)
        assert document["solver"]
        assert len(document["views"]) == len(known[0][0]["views"])
        assert all(len(view["ids"]) == len(view["points"]) for view in document["views"])


def test_concurrent_captures_all_count(stack: Server) -> None:
    """Every capture asks for the consensus; whichever computation comes last, it considered all of them."""

    def run(seed: int) -> Any:
        return Truth(seed=seed).calibrate(Client(stack), camera="Camera of six at once", **BRIEF)

    with ThreadPoolExecutor(6) as pool:
        states = list(pool.map(run, range(6)))
    assert len({state["calibration_id"] for state in states}) == 6
    published(stack, states[0]["calibration_id"], 6)
    answer = Client(stack).lookup(camera="Camera of six at once")
    assert (answer.status, answer.json["calibrations"]) == (200, 6)


def test_without_agreement_there_is_no_answer(stack: Server) -> None:
    """Five captures under one label with lenses of five focal lengths: nothing to rely on."""
    for n in range(5):
        truth = Truth(fx=700.0 + 150 * n, fy=700.0 + 150 * n, seed=n)
        state = truth.calibrate(Client(stack), camera="One label, five lenses", **BRIEF)
    published(stack, state["calibration_id"], 5)
    answer = Client(stack).lookup(camera="One label, five lenses")
    assert (answer.status, answer.json["reason"]) == (307, "disagree")


#: of each corner set: the board's squares, and the distortion model
REAL = {"jy_left": ([9, 7], "fisheye"), "pv_charuco_480": ([8, 8], "rectilinear")}


def calibrated_by_opencv(
    views: list[dict[str, Any]], size: tuple[int, int], model: str
) -> tuple[float, np.ndarray]:
    """Error in px rms, and camera matrix (3, 3)."""
    objects = [np.array(view["obj"], np.float64) for view in views]
    pixels = [np.array(view["img"], np.float64) for view in views]
    if model == "fisheye":
        flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
        boards, seen = [p[None] for p in objects], [q[None] for q in pixels]
        rms, matrix, *_ = cv2.fisheye.calibrate(boards, seen, size, None, None, flags=flags)
    else:
        rms, matrix, *_ = cv2.calibrateCamera(
            [p.astype(np.float32) for p in objects], [q.astype(np.float32) for q in pixels], size, None, None
        )
    return rms, matrix


@pytest.mark.parametrize("name", [*available(REAL)[:1], *thorough(*available(REAL)[1:])])
def test_real_corners_equal_opencv(client: Client, name: str) -> None:
    """Photographs of a printed board, through the API as a session sends them."""
    data = corner_set(name)
    squares, model = REAL[name]
    board = {"squares": squares, "marker_ratio": 0.75, "dictionary": "DICT_4X4_1000"}
    w, h = data["image_size"]
    lens = {"img_size": [w, h], "distortion_model": model}
    assert client.open(camera="LifeCam", **lens, board=board, target_error=0.001).status == 201
    taken, state = [], client.state()
    for view in data["views"]:
        pose = client.pose()
        ids = view.get("ids") or list(range(len(view["img"])))
        answer = client.view(pose.json["index"], ids, view["img"]).json
        if answer["status"] == "converged":
            break
        state = answer
        if answer["accepted"]:
            taken.append(view)
    assert len(taken) >= 5
    rms, matrix = calibrated_by_opencv(taken, (w, h), model)
    calibration = state["calibration"]
    found = np.array(calibration["camera_matrix"])
    for place in ((0, 0), (1, 1), (0, 2), (1, 2)):
        assert found[place] == pytest.approx(matrix[place], rel=0.01)
    # OpenCV takes the board as drawn. Its shape can only explain more.
    assert 0.7 * rms < calibration["avg_reprojection_error"] < 1.02 * rms
