"""Contributors told apart by source address, as on AWS, whatever their tokens."""

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from calibdb import schema
from calibdb.access.tokens import ApiToken, secret_hash
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import EDGE, Answer, Client, Truth
from tests.helpers.service.published import PLATFORM, calibration, mode_of, store, views

TOKENS = ("cdb_a_secret", "cdb_b_secret", "cdb_c_secret")
CHECKERS = ("192.0.2.1", "192.0.2.2", "192.0.2.3")
DAY = 86_400


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    environment = {"CONTRIBUTOR_PERIOD": str(DAY), "MIN_CONTRIBUTORS": "3", "EDGE_SECRETS": EDGE}
    with Server(environment=environment, worker=1) as stack:  # without jobs
        for token in TOKENS:
            _, token_id, secret = token.split("_")
            store(stack).tokens.create(ApiToken(token_id, secret_hash(secret), plan="development"))
        yield stack


def check(
    stack: Server,
    address: str,
    camera: str,
    seed: int = 0,
    fx: float = 950.0,
    token: str = TOKENS[1],
    **more: object,
) -> Answer:
    client = Client(stack, api_token=token, address=address)
    return client.check(views(Truth(seed=seed, fx=fx, fy=fx - 2)), camera=camera, platform=PLATFORM, **more)


def contributed(
    stack: Server, camera: str, n: int, source: str, day: int = 0, fx: float = 950.0
) -> schema.CalibrationDocument:
    made = calibration(camera, n, begun=1_700_000_000 + day * DAY, fx=fx, fy=fx - 2)
    document = made.model_copy(update={"source": source})
    store(stack).calibrations.publish(document)
    return document


def pooled(stack: Server, document: schema.CalibrationDocument) -> Any:
    return published.pooled(store(stack), document)


def look_up(stack: Server, camera: str) -> Answer:
    return Client(stack).lookup(camera=camera, platform=PLATFORM)


def test_five_tokens_at_one_address_are_one_contributor(stack: Server) -> None:
    for n in range(5):
        document = contributed(stack, "One who captures all day", n, "one place")
    found = pooled(stack, document)
    assert (found.total, found.reason) == (1, "too_few")
    for n in range(5, 9):  # the same on the days after
        contributed(stack, "One who captures all day", n, "one place", day=n)
    found = pooled(stack, document)
    assert (found.total, found.reason) == (3, "too_few")
    assert found.calibration.contributors == 1


def test_two_sources_are_too_few_contributors(stack: Server) -> None:
    for n, day in itertools.product(range(2), range(4)):
        document = contributed(stack, "Two places", 10 * day + n, f"place {n}", day)
    found = pooled(stack, document)
    assert (found.total, found.reason) == (6, "few_contributors")


def test_five_of_five_contributors_are_reliable(stack: Server) -> None:
    for n in range(5):
        store(stack).calibrations.publish(calibration("Five people", n))  # of old: without a source
    found = pooled(stack, calibration("Five people", 0))
    assert (found.reliable, found.calibration.contributors) == (True, 5)
    answer = look_up(stack, "Five people").json
    assert 0 < answer["uncertainty"]["inside"] <= 1.5
    assert 0.5 < answer["uncertainty"]["covered"] <= 1


def test_contributor_has_one_vote_a_day_and_none_on_own_calibration(stack: Server) -> None:
    camera = "Checked by three"
    home = Client(stack, api_token=TOKENS[0], address="198.51.100.7")
    state = Truth(seed=4).calibrate(home, camera=camera, platform=PLATFORM)
    pooled(stack, *store(stack).calibrations.read([state["calibration_id"]]))
    for token in TOKENS:
        own = check(stack, home.address, camera, token=token).json
        assert (own["fits"], own["counted"], own["votes"]["agree"]) == ("fits", False, 0)
    first = [check(stack, CHECKERS[0], camera, seed, token=TOKENS[seed]).json for seed in range(3)]
    assert [answer["votes"]["agree"] for answer in first] == [1, 1, 1]
    assert check(stack, CHECKERS[1], camera).json["votes"]["agree"] == 2
    third = check(stack, CHECKERS[2], camera).json
    assert (third["votes"]["agree"], third["calibration"]["basis"]) == (3, "checked")
    assert third["calibration"]["spread"] is None, "of one there is none"
    found = look_up(stack, camera)
    assert (found.status, found.json["reliable"], found.json["calibrations"]) == (200, True, 1)


@pytest.mark.parametrize(("noise", "lie"), [(0.2, 1.02), (1.0, 1.1)])
def test_honest_checks_confirm_no_wrong_calibration_however_noisy(
    stack: Server, noise: float, lie: float
) -> None:
    """Its own noise and uncertainty, its maker's to choose, are no measure for others' views."""
    camera = f"A lie of {lie}"
    document = calibration(camera, 0, views=12, noise=noise, fx=950 * lie, fy=948 * lie)
    precise = {"uncertainty": schema.Uncertainty(rms=0.2, max=0.5)}  # that is said, not so
    claim = {"fits": {"rectilinear": document.fits["rectilinear"].model_copy(update=precise)}}
    store(stack).calibrations.publish(document.model_copy(update={**claim, "source": "liar"}))
    assert pooled(stack, document).calibration is not None
    answers = [check(stack, a, camera, seed).json for seed, a in enumerate(CHECKERS)]
    assert [a["fits"] for a in answers] == ["does_not_fit"] * 3
    assert look_up(stack, camera).json["reason"] == "disagree"


def test_cropped_stream_is_not_compared_with_native_streams(stack: Server) -> None:
    camera = "Cropped"
    document = contributed(stack, camera, 0, "somewhere")
    pooled(stack, document)
    assert check(stack, CHECKERS[0], camera, resize_mode="crop-and-scale").status == 404
    assert store(stack).votes.newest(mode_of(document), one_per_source=True) == []
    assert check(stack, CHECKERS[0], camera, 100, resize_mode="none").json["counted"] is True


def test_no_address_is_kept(stack: Server) -> None:
    """After all of the above: neither in what is stored nor in the names it is stored under."""
    objects = stack.storage.objects
    names = list(objects.names(""))
    assert any(name.startswith("votes/") for name in names)
    for name in names:
        content = name.encode() + (objects.get(name) or b"")
        own = () if name.startswith("tokens/") else ("127.0.0.1",)  # the development token names its origins
        for secret in (*CHECKERS, "198.51.100", "cdb_", *own):
            assert secret.encode() not in content
