"""Bad input to rigs: each is a problem that names the field, and changes nothing."""

from collections.abc import Iterator
from typing import Any

import pytest

from infra.server.server import Server
from tests.helpers.service.client import CAMERA, EDGE, TOKEN, Answer, Client
from tests.helpers.service.rigs import RigTruth
from tests.helpers.service.strangers import standing_clock

WRONG = "no rig can be joined by this code; codes last 15 minutes: ask for a new one"


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    """A stack whose clock stands: guesses are counted anew in each quarter of an hour."""
    with standing_clock(), Server(environment={"EDGE_SECRETS": EDGE}) as stack:
        yield stack


def fields(answer: Answer) -> dict[str, str]:
    assert answer.status == 422, answer
    return {error["field"]: error["detail"] for error in answer.json["errors"]}


def kind(answer: Answer) -> tuple[int, str]:
    return answer.status, answer.kind


@pytest.fixture(scope="module")
def rig(stack: Server) -> RigTruth:
    """Two cameras that share one moment."""
    rig = RigTruth(stack, seed=1).open()
    rig.moment("m0")
    return rig


def joining(stack: Server, address: str = "", **more: Any) -> Answer:
    return Client(stack, address=address).open(**more)


def test_wrong_expired_and_used_up_codes_are_answered_alike(rig: RigTruth) -> None:
    """The rig is full, so that its code is used up."""
    address = "192.0.2.1"
    request = {key: value for key, value in rig.request(1).items() if key == "board"}
    for code in ("AAAAAA", "22", "O0O0O0", "äöüßñç", rig.join_code):
        assert fields(joining(rig.stack, address, rig={"code": code}, **request)) == {"rig.code": WRONG}


def test_guesses_are_limited_by_source_and_the_right_code_then_waits_too(stack: Server) -> None:
    open_rig = RigTruth(stack, count=3, seed=2).open()
    client = Client(stack)
    client.open()
    fresh = client.call("POST", "/v1/rigs", {"cameras": 2}).json["join_code"]
    assert open_rig.rig_id
    attacker = "192.0.2.2"
    for _ in range(10):
        assert joining(stack, attacker, rig={"code": "AAAAAA"}).status == 422
    for code in ("AAAAAA", fresh):
        refused = joining(stack, attacker, rig={"code": code})
        assert kind(refused) == (429, "quota")
        assert 0 < int(refused.headers["retry-after"]) <= 900
    assert joining(stack, "192.0.2.3", rig={"code": fresh}).status == 201, "others are not hindered"


def test_right_codes_are_no_guesses(stack: Server) -> None:
    client = Client(stack)
    client.open()
    for _ in range(2):
        code = client.call("POST", "/v1/rigs", {"cameras": 8}).json["join_code"]
        for _ in range(6):
            again = Client(stack, address="192.0.2.4")
            joined = again.open(rig={"code": code})
            assert joined.status == 201, joined.body
            assert again.call("DELETE", "/v1/session").status == 204, "which frees the position"


@pytest.mark.parametrize(
    ("wanted", "field"),
    [
        ({"position": 1}, "rig"),
        ({"code": "AAAAAA", "id": "0" * 32}, "rig"),
        ({"id": "0" * 32}, "rig.id"),
        ({"id": "nonsense"}, "rig.id"),
        ({"code": 7}, "rig.code"),
        ({"code": "A" * 33}, "rig.code"),
        ({"id": "0" * 32, "position": 8}, "rig.position"),
        ({"id": "0" * 32, "position": -1}, "rig.position"),
        ({"id": "0" * 32, "place": 1}, "rig.place"),
    ],
)
def test_malformed_rig_of_a_session_names_the_field(stack: Server, wanted: Any, field: str) -> None:
    client = Client(stack, address="192.0.2.5")
    assert set(fields(client.open(rig=wanted))) == {field}
    assert client.call("GET", "/v1/session").status == 404, "no session was started"


def test_camera_too_many_and_position_taken_name_the_position(rig: RigTruth) -> None:
    body = {key: value for key, value in rig.request(1).items() if key == "board"}
    found = fields(joining(rig.stack, rig={"id": rig.rig_id}, **body))
    assert found == {"rig.position": "The rig has all its 2 cameras."}
    client = Client(rig.stack)
    client.open(**body)
    three = client.call("POST", "/v1/rigs", {"cameras": 3}).json["rig_id"]
    assert joining(rig.stack, rig={"id": three, "position": 2}, **body).status == 201
    assert fields(joining(rig.stack, rig={"id": three, "position": 2}, **body)) == {
        "rig.position": "taken; free: 1"
    }
    for position in (0, 3):
        assert set(fields(joining(rig.stack, rig={"id": three, "position": position}, **body))) == {
            "rig.position"
        }


def test_session_that_joined_cannot_take_another_position(rig: RigTruth) -> None:
    session = rig.clients[1]
    again = session.call("POST", "/v1/session", {**rig.request(1), "rig": {"code": "AAAAAA"}})
    assert (again.status, again.json["rig"]["position"]) == (201, 1), "its place is known without a code"
    other = session.call("POST", "/v1/session", {**rig.request(1), "rig": {"id": rig.rig_id, "position": 0}})
    assert kind(other) == (409, "other-content")


def test_another_board_is_refused(stack: Server) -> None:
    client = Client(stack)
    client.open()
    code = client.call("POST", "/v1/rigs", {"cameras": 2}).json["join_code"]
    other = joining(stack, board={"squares": [8, 6]}, rig={"code": code})
    assert set(fields(other)) == {"board"}
    assert joining(stack, rig={"code": code}).status == 201, "it cost nothing"


def test_board_that_half_a_turn_leaves_alike_cannot_lead(stack: Server) -> None:
    client = Client(stack)
    client.open(board={"kind": "chessboard", "squares": [9, 7]})
    assert set(fields(client.call("POST", "/v1/rigs", {"cameras": 2}))) == {"board"}
    assert client.state()["rig"] is None
    client = Client(stack)
    client.open(board={"kind": "chessboard", "squares": [10, 7]})
    assert client.call("POST", "/v1/rigs", {"cameras": 2}).status == 201


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"cameras": 1}, "cameras"),
        ({"cameras": 9}, "cameras"),
        ({}, "cameras"),
        ({"cameras": 2, "square_size": 0}, "square_size"),
        ({"cameras": 2, "square_size": "3 cm"}, "square_size"),
        ({"cameras": 2, "colour": 1}, "colour"),
    ],
)
def test_malformed_rig_names_the_field(stack: Server, body: Any, field: str) -> None:
    client = Client(stack)
    client.open()
    assert set(fields(client.call("POST", "/v1/rigs", body))) == {field}


def test_rig_is_made_once_by_a_session_without_views(rig: RigTruth) -> None:
    leader, follower = rig.clients
    again = leader.call("POST", "/v1/rigs", {"cameras": 2}).json
    assert again["rig_id"] == rig.rig_id
    assert kind(leader.call("POST", "/v1/rigs", {"cameras": 3})) == (409, "other-content")
    assert kind(leader.call("POST", "/v1/rigs", {"cameras": 2, "square_size": 1})) == (409, "other-content")
    assert kind(follower.call("POST", "/v1/rigs", {"cameras": 2})) == (409, "in-rig")
    alone = Client(rig.stack)
    assert kind(alone.call("POST", "/v1/rigs", {"cameras": 2}, token="x")) == (403, "forbidden")
    alone.open()
    pose = alone.pose().json
    assert alone.view(pose["index"], *rig.cameras[0].see(pose)).json["accepted"]
    assert kind(alone.call("POST", "/v1/rigs", {"cameras": 2})) == (409, "has-views")


def test_moment_that_was_never_opened_undone_or_doubled(rig: RigTruth) -> None:
    seen = rig.see(1, rig.held())
    view = {"ids": seen[0], "points": seen[1]}
    send = rig.clients[1].call

    def sent(**more: Any) -> Answer:
        return send("POST", "/v1/session/views", {**view, **more})

    assert set(fields(sent())) == {"moment"}
    assert set(fields(sent(moment="never"))) == {"moment"}
    assert set(fields(sent(moment="with space"))) == {"moment"}
    assert kind(sent(moment="m0")) == (409, "other-content"), "the camera has another view of it"
    for bad in ("", "a b", "x" * 65, 7):
        assert set(fields(rig.call("POST", "/moments", {"moment": bad}))) == {"moment"}
    assert set(fields(rig.call("DELETE", "/moments/never"))) == {"moment"}
    assert rig.call("POST", "/moments", {"moment": "gone"}).status == 201
    assert rig.call("DELETE", "/moments/gone").status == 200
    assert kind(sent(moment="gone")) == (409, "moment-undone")
    alone = Client(rig.stack)
    alone.open()
    assert set(fields(alone.call("POST", "/v1/session/views", {**view, "index": 0, "moment": "m0"}))) == {
        "moment"
    }
    assert set(fields(alone.call("POST", "/v1/session/views", view))) == {"index"}


def test_only_the_leader_leads(rig: RigTruth) -> None:
    stranger = Client(rig.stack)
    stranger.open()
    for client in (rig.clients[1], stranger):
        for method, path, body in (
            ("POST", "/moments", {"moment": "mine"}),
            ("DELETE", "/moments/m0", None),
            ("POST", "/finish", None),
            ("DELETE", "", None),
        ):
            answer = client.call(method, f"/v1/rigs/{rig.rig_id}{path}", body)
            assert kind(answer) == (403, "not-leader"), (method, path)
        skipped = client.call("GET", f"/v1/rigs/{rig.rig_id}", query="skip=1")
        assert kind(skipped) == (403, "not-leader")
    assert kind(rig.call("GET", query="skip=1", token=TOKEN)) == (403, "forbidden")
    assert rig.call("GET", token="").status == 401


def test_sessions_of_a_rig_end_through_it_alone(rig: RigTruth) -> None:
    for client in rig.clients:
        assert kind(client.call("POST", "/v1/session/finish")) == (409, "in-rig")
        assert kind(client.call("DELETE", "/v1/session/views/0")) == (409, "in-rig")
    assert kind(rig.call("POST", "/finish")) == (409, "too-few-views")
    assert kind(rig.call("GET", "/result", token=TOKEN)) == (404, "rig-unfinished")
    found = fields(rig.call("GET", "/result", token=TOKEN, query="format=bag"))
    assert "opencv_stereo, ros, kalibr" in found["format"]


def test_rig_that_is_not_there(rig: RigTruth) -> None:
    for unknown in ("0" * 32, "nonsense"):
        for method, path, body in (
            ("GET", "", None),
            ("GET", "/result", None),
            ("DELETE", "", None),
            ("POST", "/moments", {"moment": "m"}),
            ("DELETE", "/moments/m", None),
            ("POST", "/finish", None),
        ):
            answer = rig.clients[0].call(method, f"/v1/rigs/{unknown}{path}", body)
            assert kind(answer) == (404, "no-rig"), (method, path)


def test_rig_whose_cameras_all_left_waits_for_them(stack: Server) -> None:
    rig = RigTruth(stack, seed=9).open()
    rig.moment("m0")
    for client in rig.clients:
        assert client.call("DELETE", "/v1/session").status == 204
    state = rig.call("GET", token=TOKEN).json
    assert [camera["status"] for camera in state["cameras"]] == ["waiting", "waiting"]
    assert (state["target"], state["uncertainty"], state["unlinked"]) == (None, None, [0, 1])


def test_forgotten_rig_leaves_sessions_alone_that_are_in_another(stack: Server) -> None:
    first, second = RigTruth(stack, seed=31).open(), RigTruth(stack, seed=32, count=3).open()
    moved = first.clients[1]
    assert moved.call("DELETE", "/v1/session").status == 204
    wanted = {"code": second.join_code}
    second.clients[2].call("DELETE", "/v1/session")
    assert moved.call("POST", "/v1/session", {**second.request(2), "rig": wanted}).status == 201
    assert first.call("DELETE").status == 204
    assert moved.call("GET", "/v1/session").status == 200
    assert second.state()["cameras"][2]["status"] == "capturing"


def test_forgotten_rig_leaves_nothing_running(stack: Server) -> None:
    rig = RigTruth(stack, seed=8).open()
    rig.moment("m0")
    for _ in range(2):
        assert rig.call("DELETE").status == 204
    assert kind(rig.call("GET")) == (404, "no-rig")
    for client in rig.clients:
        assert client.call("GET", "/v1/session").status == 404
    leader = rig.clients[0]
    assert leader.call("POST", "/v1/session", {**CAMERA}).status == 201
    assert leader.call("POST", "/v1/rigs", {"cameras": 2}).json["rig_id"] != rig.rig_id
