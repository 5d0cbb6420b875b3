"""Bad input is refused by name, with a 4xx problem, and the session goes on unharmed."""

import gzip
from collections.abc import Iterator
from typing import Any

import pytest

from infra.server.server import Server
from tests.helpers.service.client import CAMERA, Client, Truth

MISSING = object()
MALFORMED = [
    b"",
    b'{"camera": "a",}',
    b"\xff\xfe{}",
    b'{"camera": "\\ud800"}',
    b"[" * 100_000,
]
# field changed, its value, and the field that the answer must name
IN_A_SESSION: list[tuple[str, Any, str]] = [
    ("camera", MISSING, "camera"),
    ("camera", 5, "camera"),
    ("camera", "   ", "camera"),
    ("platform", "x" * 257, "platform"),
    ("img_size", [0, 720], "img_size.0"),
    ("img_size", [16384, 16384], "img_size"),  # more than a picture of the pose could show
    ("img_size", [64, 4096], "img_size"),  # no camera's
    ("img_size", [True, 720], "img_size.0"),
    ("img_size", [10**400, 720], "img_size.0"),
    ("zoom", float("nan"), "zoom"),
    ("zoom", -1, "zoom"),
    ("distortion_model", "pinhole", "distortion_model"),
    ("board", "9x6", "board"),
    ("board", {"squares": [51, 6]}, "board.squares.0"),
    ("board", {"squares": [9, 2]}, "board.squares.1"),  # one row of corners
    ("board", {"squares": [3, 3]}, "board.squares"),  # four corners, too few for any view
    ("board", {"marker_ratio": float("nan")}, "board.marker_ratio"),
    ("board", {"squares": [12, 9]}, "board.dictionary"),  # 54 markers of a dictionary of 50
    ("guidance", "random", "guidance"),
    ("target_error", float("inf"), "target_error"),
    ("track", {"frameRate": float("nan")}, "track.frameRate"),
    ("track", {"facingMode": "x" * 65}, "track.facingMode"),
    ("target_eror", 0.3, "target_eror"),
]
GRID = [[100.0 + 90 * (i % 8), 100.0 + 90 * (i // 8)] for i in range(40)]
IN_A_VIEW: list[tuple[str, Any, str]] = [
    ("index", MISSING, "index"),
    ("index", 10**30, "index"),
    ("ids", [*range(39), 40], "ids.39"),  # the board has 0 to 39
    ("ids", [*range(39), 38], "ids"),
    ("ids", list(range(39)), "points"),
    ("ids", list(range(10_000)), "ids"),
    ("points", [*GRID[:39], [float("nan"), 1]], "points.39.0"),
    ("points", [*GRID[:39], [1279.6, 1]], "points.39"),
    ("points", [*GRID[:39], [1]], "points.39"),
    ("points", [*GRID[:39], ["1", "2"]], "points.39.0"),
    ("view", 0, "view"),
]


def changed(body: dict[str, Any], field: str, value: Any) -> dict[str, Any]:
    rest = {name: content for name, content in body.items() if name != field}
    return rest if value is MISSING else {**rest, field: value}


@pytest.fixture(scope="module")
def guided(stack: Server) -> Iterator[Client]:
    """A session with one view, which is found as it was after everything that was tried on it."""
    client = Client(stack)
    client.open()
    assert Truth().show(client).json["accepted"]
    before = client.state()
    yield client
    assert client.state() == before
    assert Truth(seed=1).show(client).json["accepted"]


PATHS = ("/v1/session", "/v1/session/views", "/v1/lookup")


@pytest.mark.parametrize("body", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_json(guided: Client, body: bytes) -> None:
    assert guided.call("POST", "/v1/session/views", body).status == 400


@pytest.mark.parametrize("path", PATHS)
def test_json_other_than_an_object(guided: Client, path: str) -> None:
    assert guided.call("POST", path, b"{").status == 400
    for body in (b"[]", b"null"):
        assert guided.call("POST", path, body).fields == ["body"]


@pytest.mark.parametrize("path", PATHS)
def test_a_body_too_large(guided: Client, path: str) -> None:
    assert guided.call("POST", path, b'{"camera": "' + b"x" * 1_000_000 + b'"}').status == 413


@pytest.mark.parametrize("encoding", ["gzip", "deflate", "br", "identity"])
def test_a_compressed_body_is_never_unpacked(client: Client, encoding: str) -> None:
    bomb = gzip.compress(b" " * 5_000_000 + b'{"camera": "x"}')
    assert len(bomb) < 10_000
    assert client.call("POST", "/v1/lookup", bomb, headers={"content-encoding": encoding}).status == 400


@pytest.mark.parametrize(("field", "value", "name"), IN_A_SESSION)
def test_session(client: Client, field: str, value: Any, name: str) -> None:
    client.authenticate()
    assert name in client.call("POST", "/v1/session", changed(CAMERA, field, value)).fields
    assert client.call("GET", "/v1/session").status == 404
    assert client.call("POST", "/v1/session", CAMERA).status == 201


@pytest.mark.parametrize(("field", "value", "name"), IN_A_VIEW)
def test_view(guided: Client, field: str, value: Any, name: str) -> None:
    view = {"index": 1, "ids": list(range(40)), "points": GRID}
    refused = guided.call("POST", "/v1/session/views", changed(view, field, value)).fields
    assert any(found == name or found.startswith(f"{name}.") for found in refused)


def test_views_of_no_board_are_judged(client: Client) -> None:
    client.open()
    places = (
        [[640.0, 360.0]] * 40,
        [[30.0 * i, 360.0] for i in range(40)],
        [[x, 360 + 0.01 * y] for x, y in GRID],  # a sliver
        [[640 + (x - 415) * (y - 280) / 180, y] for x, y in GRID],  # a bow tie
        [GRID[7 * i % 40] for i in range(40)],
    )
    for points in (*places, *places):
        index = len(client.state()["views"])
        assert client.view(index, list(range(40)), points).status == 200
        assert client.pose().status == 200


@pytest.mark.parametrize(
    ("query", "name"),
    [
        ("", "camera"),
        ("camera=a&platform=X11&img_size=0x720", "img_size.0"),
        ("camera=a&platform=X11&img_size=1280x720&zoom=1e999", "zoom"),
        ("camera=a&platform=X11&img_size=1280x720&redirect=maybe", "redirect"),
        ("camera=%00%ff&platform=X11&img_size=", "img_size"),
    ],
)
def test_lookup_by_get(client: Client, query: str, name: str) -> None:
    assert name in client.call("GET", "/v1/lookup", query=query).fields


@pytest.mark.parametrize("skip", ["2", ""])
def test_pose(guided: Client, skip: str) -> None:
    assert guided.pose(f"skip={skip}").fields == ["skip"]


@pytest.mark.parametrize("index", ["-1", "x", "9999999999", "٣"])
def test_undo(guided: Client, index: str) -> None:
    assert guided.call("DELETE", f"/v1/session/views/{index}").fields == ["index"]


def test_undo_of_an_unknown_view(guided: Client) -> None:
    assert guided.call("DELETE", "/v1/session/views/77").status == 404


def test_calls_before_the_start_of_the_session(client: Client) -> None:
    client.authenticate()
    assert client.call("GET", "/v1/session").status == 404
    assert client.forget().status == 404
    assert client.pose().status == 404
    assert client.view(0, [0], [[1, 1]]).status == 404
    assert client.call("DELETE", "/v1/session/views/0").status == 404


def test_whole_numbers_may_be_written_with_a_point(client: Client) -> None:
    client.open(img_size=[1280.0, 720.0], board={"squares": [9.0, 6.0]})
    state = client.state()
    assert (state["img_size"], state["board"]["squares"]) == ([1280, 720], [9, 6])
    ids, points = Truth().see(client.pose().json)
    assert client.view(0.0, [float(i) for i in ids], points).json["accepted"]
    assert client.view(0, ids, points).json["accepted"]  # the same once more
    assert client.lookup(img_size=[1280.0, 720.0], redirect=False).status == 404


def test_wrong_field_is_not_reported_missing(guided: Client) -> None:
    view = {"index": 1, "ids": [0.5], "points": [[1.0, 2.0]]}
    assert guided.call("POST", "/v1/session/views", view).fields == ["ids.0"]
    view = {"index": 1, "ids": [], "points": [[1.0, 2.0]]}
    assert guided.call("POST", "/v1/session/views", view).fields == ["ids"]


def test_problem_names_the_first_wrong_fields(guided: Client) -> None:
    assert len(guided.view(1, list(range(40)), [[5000.0, 5000.0]] * 40).fields) == 20


@pytest.mark.parametrize(
    ("path", "query", "says"),
    [
        ("/v1/lookup", "camera=x&platform=y&img_size=1280", "1280x720"),
        ("/v1/calibrations/x", "crop=1,2", "4 whole numbers"),
        ("/v1/calibrations/x", "rotate=%C2%B2", "90"),
        ("/v1/calibrations/x", "without=1,", "indices of views"),
        ("/v1/calibrations/x", f"without={'1,' * 64}1", "List should have at most 64 items"),
    ],
)
def test_error_names_the_constraint_without_internals(
    client: Client, path: str, query: str, says: str
) -> None:
    (error,) = client.call("GET", path, query=query).json["errors"]
    assert says in error["detail"]
    for internal in ("Value error", "int()", "Tuple", "after validation"):
        assert internal not in error["detail"]
