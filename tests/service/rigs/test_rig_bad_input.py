"""Bad input to rigs."""

from collections.abc import Iterator
from typing import Any

import pytest

from infra.server.server import Server
from tests.helpers.service.client import EDGE, TOKEN, Answer, Client
from tests.helpers.service.rigs import RigTruth
from tests.helpers.service.strangers import standing_clock

WRONG = "no rig can be joined by this code; codes last 15 minutes: ask for a new one"


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    """A stack whose clock stands: guesses are counted anew in each quarter of an hour."""
    with standing_clock(), Server(environment={"EDGE_SECRETS": EDGE}) as stack:
        yield stack


@pytest.fixture(scope="module")
def rig(stack: Server) -> RigTruth:
    rig = RigTruth(stack, seed=1).open()
    rig.moment("m0")
    return rig


def joining(stack: Server, address: str = "", **more: Any) -> Answer:
    return Client(stack, address=address).open(**more)


def board_of(rig: RigTruth) -> dict[str, object]:
    return {"board": rig.request(0)["board"]}


def details(answer: Answer) -> dict[str, str]:
    return {error["field"]: error["detail"] for error in answer.json["errors"]}


def lead(client: Client, cameras: int = 2, **rig: object) -> Answer:
    return client.call("POST", "/v1/rigs", {"cameras": cameras, **rig})


def code_of(stack: Server) -> str:
    client = Client(stack)
    client.open()
    return str(lead(client).json["join_code"])


def test_wrong_expired_and_used_up_codes_are_answered_alike(rig: RigTruth) -> None:
    for code in ("AAAAAA", "22", "O0O0O0", "äöüßñç", rig.join_code):
        refused = joining(rig.stack, "192.0.2.1", rig={"code": code}, **board_of(rig))
        assert details(refused) == {"rig.code": WRONG}


def test_guesses_are_limited_by_source_and_the_right_code_then_waits_too(stack: Server) -> None:
    fresh = code_of(stack)
    attacker = "192.0.2.2"
    for _ in range(10):
        assert joining(stack, attacker, rig={"code": "AAAAAA"}).status == 422
    for code in ("AAAAAA", fresh):
        refused = joining(stack, attacker, rig={"code": code})
        assert refused.problem == (429, "quota")
        assert 0 < int(refused.headers["retry-after"]) <= 900
    assert joining(stack, "192.0.2.3", rig={"code": fresh}).status == 201, "others are not hindered"


def test_right_codes_are_no_guesses(stack: Server) -> None:
    code = code_of(stack)
    for _ in range(11):
        client = Client(stack, address="192.0.2.4")
        assert client.open(rig={"code": code}).status == 201
        assert client.forget().status == 204, "which frees the position"


@pytest.mark.parametrize(
    ("wanted", "field"),
    [
        ({"position": 1}, "rig"),
        ({"code": "AAAAAA", "id": "0" * 32}, "rig"),
        ({"id": "0" * 32}, "rig.id"),
        ({"code": "A" * 33}, "rig.code"),
        ({"id": "0" * 32, "position": 8}, "rig.position"),
        ({"id": "0" * 32, "place": 1}, "rig.place"),
    ],
)
def test_malformed_rig_of_a_session_names_the_field(stack: Server, wanted: Any, field: str) -> None:
    client = Client(stack, address="192.0.2.5")
    assert client.open(rig=wanted).fields == [field]
    assert client.call("GET", "/v1/session").status == 404, "no session was started"


def test_camera_too_many_and_position_taken_name_the_position(rig: RigTruth) -> None:
    board = board_of(rig)
    found = details(joining(rig.stack, rig={"id": rig.rig_id}, **board))
    assert found == {"rig.position": "The rig has all its 2 cameras."}
    client = Client(rig.stack)
    client.open(**board)
    three = lead(client, 3).json["rig_id"]
    assert joining(rig.stack, rig={"id": three, "position": 2}, **board).status == 201
    found = details(joining(rig.stack, rig={"id": three, "position": 2}, **board))
    assert found == {"rig.position": "taken; free: 1"}
    for position in (0, 3):
        assert joining(rig.stack, rig={"id": three, "position": position}, **board).fields == ["rig.position"]


def test_session_that_joined_cannot_take_another_position(rig: RigTruth) -> None:
    def start(**wanted: object) -> Answer:
        return rig.clients[1].call("POST", "/v1/session", {**rig.request(1), "rig": wanted})

    assert start(code="AAAAAA").json["rig"]["position"] == 1, "its place is known without a code"
    assert start(id=rig.rig_id, position=0).problem == (409, "other-content")


def test_another_board_is_refused(stack: Server) -> None:
    code = code_of(stack)
    assert joining(stack, board={"squares": [8, 6]}, rig={"code": code}).fields == ["board"]
    assert joining(stack, rig={"code": code}).status == 201, "it cost nothing"


def test_board_that_half_a_turn_leaves_alike_cannot_lead(stack: Server) -> None:
    client = Client(stack)
    client.open(board={"kind": "chessboard", "squares": [9, 7]})
    assert lead(client).fields == ["board"]
    client.open(board={"kind": "chessboard", "squares": [10, 7]})
    assert lead(client).status == 201


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"cameras": 9}, "cameras"),
        ({"cameras": 2, "square_size": 0}, "square_size"),
        ({"cameras": 2, "colour": 1}, "colour"),
    ],
)
def test_malformed_rig_names_the_field(stack: Server, body: Any, field: str) -> None:
    client = Client(stack)
    client.open()
    assert client.call("POST", "/v1/rigs", body).fields == [field]


def test_rig_is_made_once_by_a_session_without_views(rig: RigTruth) -> None:
    leader, follower = rig.clients
    assert lead(leader).json["rig_id"] == rig.rig_id
    assert lead(leader, 3).problem == (409, "other-content")
    assert lead(leader, square_size=1).problem == (409, "other-content")
    assert lead(follower).problem == (409, "in-rig")
    alone = Client(rig.stack)
    assert alone.call("POST", "/v1/rigs", {"cameras": 2}, token="x").problem == (403, "forbidden")
    alone.open()
    pose = alone.pose().json
    assert alone.view(pose["index"], *rig.cameras[0].see(pose)).json["accepted"]
    assert lead(alone).problem == (409, "has-views")


def test_moment_that_was_never_opened_undone_or_doubled(rig: RigTruth) -> None:
    ids, points = rig.see(1, rig.held())

    def sent(client: Client = rig.clients[1], **more: Any) -> Answer:
        return client.call("POST", "/v1/session/views", {"ids": ids, "points": points, **more})

    assert sent().fields == ["moment"]
    assert sent(moment="never").fields == ["moment"]
    assert sent(moment="m0").problem == (409, "other-content"), "the camera has another view of it"
    for bad in ("", "a b", "x" * 65, 7):
        assert rig.call("POST", "/moments", {"moment": bad}).fields == ["moment"]
    assert rig.call("DELETE", "/moments/never").fields == ["moment"]
    assert rig.call("POST", "/moments", {"moment": "gone"}).status == 201
    assert rig.call("DELETE", "/moments/gone").status == 200
    assert sent(moment="gone").problem == (409, "moment-undone")
    alone = Client(rig.stack)
    alone.open()
    assert sent(alone, index=0, moment="m0").fields == ["moment"]
    assert sent(alone).fields == ["index"]


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
            assert answer.problem == (403, "not-leader"), (method, path)
        skipped = client.call("GET", f"/v1/rigs/{rig.rig_id}", query="skip=1")
        assert skipped.problem == (403, "not-leader")
    assert rig.call("GET", query="skip=1", token=TOKEN).problem == (403, "forbidden")
    assert rig.call("GET", token="").status == 401


def test_sessions_of_a_rig_end_through_it_alone(rig: RigTruth) -> None:
    for client in rig.clients:
        assert client.finish().problem == (409, "in-rig")
        assert client.call("DELETE", "/v1/session/views/0").problem == (409, "in-rig")
    assert rig.call("POST", "/finish").problem == (409, "too-few-views")
    assert rig.call("GET", "/result", token=TOKEN).problem == (404, "rig-unfinished")
    found = details(rig.call("GET", "/result", token=TOKEN, query="format=bag"))
    assert "opencv_stereo, ros, kalibr" in found["format"]


def test_rig_that_is_not_there(rig: RigTruth) -> None:
    for unknown in ("0" * 32, "nonsense"):
        for method, path, body in (
            ("GET", "", None),
            ("GET", "/result", None),
            ("DELETE", "", None),
            ("POST", "/moments", {"moment": "m"}),
            ("POST", "/finish", None),
        ):
            answer = rig.clients[0].call(method, f"/v1/rigs/{unknown}{path}", body)
            assert answer.problem == (404, "no-rig"), (method, path)


def test_rig_whose_cameras_all_left_waits_for_them(stack: Server) -> None:
    rig = RigTruth(stack, seed=9).open()
    rig.moment("m0")
    for client in rig.clients:
        assert client.forget().status == 204
    state = rig.call("GET", token=TOKEN).json
    assert [camera["status"] for camera in state["cameras"]] == ["waiting", "waiting"]
    assert (state["target"], state["uncertainty"], state["unlinked"]) == (None, None, [0, 1])


def test_forgotten_rig_leaves_sessions_alone_that_are_in_another(stack: Server) -> None:
    first, second = RigTruth(stack, seed=31).open(), RigTruth(stack, seed=32, count=3).open()
    moved = first.clients[1]
    assert moved.forget().status == 204
    wanted = {"code": second.join_code}
    second.clients[2].forget()
    assert moved.call("POST", "/v1/session", {**second.request(2), "rig": wanted}).status == 201
    assert first.call("DELETE").status == 204
    assert moved.call("GET", "/v1/session").status == 200
    assert second.state()["cameras"][2]["status"] == "capturing"
