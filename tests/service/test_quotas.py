"""Plans, as a caller meets them."""

import zlib
from collections.abc import Iterator

import pytest

from calibdb.access.plans import PLANS, Allowance, Plan
from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.store import Store
from infra.server.server import Server
from tests.helpers.service.client import CAMERA, Answer, Client
from tests.helpers.service.stores import override_service
from tests.helpers.service.strangers import standing_clock

UNKNOWN = "c1-a-0123456789ab-0123456789abcdef0123"
SMALL = Plan(Allowance(3, 4, 5, 6), Allowance(3, 4, 5, 6))


@pytest.fixture(scope="module", autouse=True)
def small_plan() -> Iterator[None]:
    with standing_clock(plans=PLANS | {"small": SMALL}):
        yield


@pytest.fixture
def client(stack: Server, store: Store, request: pytest.FixtureRequest) -> Client:
    name = str(zlib.crc32(request.node.name.encode()))
    store.tokens.create(ApiToken(name, secret_hash("x"), plan="small"))
    return Client(stack, api_token=f"cdb_{name}_x")


def assert_used_up(answer: Answer) -> None:
    assert answer.problem == (429, "quota")
    assert ";r=0;t=" in answer.headers["ratelimit"]
    assert ";w=3600" in answer.headers["ratelimit-policy"]
    assert 1 <= int(answer.headers["retry-after"]) <= 3600


def test_sessions(client: Client) -> None:
    answers = [client.call("POST", "/v1/auth") for _ in range(4)]
    assert [a.status for a in answers[:3]] == [201] * 3
    assert_used_up(answers[3])
    assert Client(client.stack).open().status == 201  # another token's


def test_views_refused_ones_and_undone_ones_count(client: Client) -> None:
    client.open()
    assert [client.view(0, [0], [[1, 1]]).json["reason"] for _ in range(3)] == ["too_few_points"] * 3
    assert client.call("DELETE", "/v1/session/views/0").status == 404
    assert_used_up(client.view(0, [0], [[1, 1]]))
    assert_used_up(client.call("DELETE", "/v1/session/views/0"))
    assert client.pose().status == 200


def test_poses_in_numbers_and_as_pictures_count(client: Client) -> None:
    client.open()
    path, accept = "/v1/session/pose", {"accept": "image/jpeg"}
    answers = [client.call("GET", path, headers=accept) for _ in range(3)]
    answers += [client.call("GET", path, query="skip=1") for _ in range(2)]  # the start was one of six
    assert [a.status for a in answers] == [200] * 5
    assert_used_up(client.call("GET", path, headers=accept))
    assert_used_up(client.pose())
    assert client.view(0, [0], [[1, 1]]).status == 200


def test_starting_and_forgetting_again_and_again_counts(client: Client) -> None:
    client.authenticate()
    for method, body in [("POST", CAMERA), ("DELETE", None)] * 3:
        assert client.call(method, "/v1/session", body).status in {201, 204}
    for method in ("POST", "GET", "DELETE"):
        assert_used_up(client.call(method, "/v1/session", CAMERA))


def test_starting_anew_under_one_session_id_counts_as_a_session(client: Client) -> None:
    for _ in range(2):
        client.authenticate()
    for n in range(2):  # the first start is what was counted when the session was opened
        assert client.call("POST", "/v1/session", {**CAMERA, "camera": f"Camera {n}"}).status == 201
        assert client.forget().status == 204
    assert_used_up(client.call("POST", "/v1/session", CAMERA))
    assert client.call("GET", "/v1/session").status == 404
    assert_used_up(client.call("POST", "/v1/auth"))


def test_lookups(client: Client) -> None:
    assert [client.lookup(redirect=False).status for _ in range(5)] == [404] * 5
    assert_used_up(client.lookup())
    assert_used_up(client.calibration(UNKNOWN))


def test_conversions_count_as_views(client: Client) -> None:
    assert [client.calibration(UNKNOWN, "format=ros").status for _ in range(4)] == [404] * 4
    assert_used_up(client.calibration(UNKNOWN, "format=ros"))


def test_a_wrong_secret_counts_for_nothing(client: Client) -> None:
    for _ in range(9):
        assert client.call("POST", "/v1/auth", token=client.api_token + "y").status == 403
    assert client.call("POST", "/v1/auth").status == 201


def test_a_revoked_token_ends_its_sessions(client: Client, store: Store) -> None:
    assert client.open().status == 201
    assert client.pose().status == 200
    store.tokens.revoke(store.tokens.get(client.api_token.split("_")[1]), 0)
    with override_service(token_ttl_s=0, plans=PLANS | {"small": SMALL}):  # as if it came a minute later
        for method, path in (("GET", "/v1/session"), ("GET", "/v1/session/pose"), ("DELETE", "/v1/session")):
            assert client.call(method, path).status == 403
        assert client.view(0, [0], [[1, 1]]).status == 403
        assert client.call("POST", "/v1/auth").status == 403


def test_the_counters_expire(client: Client, stack: Server) -> None:
    client.call("POST", "/v1/auth")
    keys = stack.storage.table.keys(f"TOKEN#{client.api_token.split('_')[1]}")
    counters = [(sk.partition("#")[0], stack.storage.table.get(pk, sk)) for pk, sk in keys if sk != "META"]
    assert sorted(kind for kind, _ in counters) == ["QUOTA", "SHARE"]  # of all, of the contributor
    assert all("ttl" in item and item["sessions"] == 1 for _, item in counters)
