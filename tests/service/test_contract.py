"""Every call of the HTTP contract, answered as the contract says."""

import cv2
import numpy as np
import pytest

from infra.server.server import Server
from tests.helpers.service.client import CAMERA, Client, Truth
from tests.helpers.service.in_process import request

JOBS = False

BOARD = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}


def test_a_new_session_has_the_contracts_defaults(client: Client) -> None:
    answer = client.open()
    assert answer.status == 201
    absent = ("rig", "licence", "licence_version", "uncertainty", "systematic", "calibration")
    absent += ("calibration_id", "end", "verdict", "suggested_model")
    assert answer.json == {
        "status": "capturing",
        **CAMERA,
        "zoom": 0,
        "distortion_model": "rectilinear",
        "board": BOARD,
        "guidance": "projection-uncertainty",
        "target_error": pytest.approx(0.3),
        "capture": "live",
        "views": [],
        "progress": 0,
        "advice": [],
        **dict.fromkeys(absent),
    }
    assert client.state() == answer.json


def test_the_target_error_scales_with_the_width(client: Client) -> None:
    assert client.open(img_size=[640, 480]).json["target_error"] == pytest.approx(0.15)
    assert client.open(img_size=[640, 480], target_error=0.4).json["target_error"] == 0.4


def test_session_accepts_every_field_of_the_contract(client: Client) -> None:
    asked = {
        "zoom": 1.5,
        "distortion_model": "fisheye",
        "board": {"squares": [8, 8], "marker_ratio": 0.75, "dictionary": "DICT_4X4_1000", "legacy": True},
        "guidance": "pose-selection",
        "target_error": 0.7,
    }
    track = {"focusMode": "manual", "focusDistance": 0.4, "facingMode": "user", "resizeMode": "none"}
    track |= {"frameRate": 30, "deviceId": "what a page need not send is passed over"}
    answer = client.open(**asked, track=track)
    assert {name: answer.json[name] for name in asked} == asked
    assert client.pose().status == 200


@pytest.mark.parametrize(
    ("headers", "media_type"), [({}, "image/jpeg"), ({"accept": "text/html, image/png;q=0.9"}, "image/png")]
)
def test_the_picture_shows_the_pose(running: Client, headers: dict[str, str], media_type: str) -> None:
    outline = np.array(running.pose().json["outline"])
    answer = running.call("GET", "/v1/session/pose", headers=headers)
    assert answer.headers["content-type"] == media_type
    picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (720, 1280, 3)
    expected = np.zeros((720, 1280), np.uint8)
    cv2.fillPoly(expected, [np.round(outline).astype(np.int32)], 1)
    drawn = (picture.max(axis=2) > 24).astype(np.uint8)
    assert (drawn & expected).sum() / (drawn | expected).sum() > 0.98


def test_pose_stays_until_a_view_or_a_skip(running: Client) -> None:
    first = running.pose().json
    running.call("GET", "/v1/session/pose")
    assert running.pose().json == first
    other = running.pose("skip=1").json
    assert other["index"] == first["index"]
    assert other["corners"] != first["corners"]
    assert running.pose("skip=0").json == other
    assert running.view(0, *Truth().see(other)).json["accepted"]
    assert running.pose().json["index"] == 1


def test_a_view_becomes_part_of_the_session(running: Client) -> None:
    ids, points = Truth().see(running.pose().json)
    answer = running.view(0, ids, points).json
    assert (answer["accepted"], answer["reason"]) == (True, None)
    (view,) = answer["views"]
    assert (view["index"], view["points"]) == (0, len(ids))
    assert 0 < answer["progress"] < 1
    assert running.state()["views"] == answer["views"]


def test_undo_takes_a_view_back(running: Client) -> None:
    truth = Truth()
    for _ in range(2):
        assert truth.show(running).json["accepted"]
    answer = running.call("DELETE", "/v1/session/views/0")
    assert [view["index"] for view in answer.json["views"]] == [1]
    assert running.state()["views"] == answer.json["views"]
    assert running.pose().json["index"] == 2  # an index is never used again


def test_delete_forgets(running: Client) -> None:
    assert running.forget().status == 204
    assert running.call("GET", "/v1/session").status == 404
    assert running.pose().status == 404
    assert running.forget().status == 204  # once more is the same
    assert running.call("POST", "/v1/session", CAMERA).status == 201  # and the id can be used anew


def test_answers_are_uncached_with_nosniff(running: Client) -> None:
    for answer in (running.call("GET", "/v1/session"), running.call("PUT", "/v1/session"), running.lookup()):
        assert answer.headers["cache-control"] == "no-store"
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_head_is_answered_like_get(stack: Server) -> None:
    assert request(stack, "HEAD", "/healthz").status == 200
