"""Where contributors can be told apart, as on AWS: each counts once a day, and three of them are needed."""

from collections.abc import Iterator

import pytest

from calibdb.tokens import ApiToken, secret_hash
from infra.local import LocalStack
from tests.client import CAMERA, Answer, Client, Truth, until
from tests.published import PLATFORM, asked, calibration, held, mode_of, store

VOTERS = ("cdb_a_secret", "cdb_b_secret", "cdb_c_secret")


@pytest.fixture(scope="module")
def stack() -> Iterator[LocalStack]:
    environment = {"CONTRIBUTOR_PERIOD": "86400", "MIN_CONTRIBUTORS": "3"}
    with LocalStack(environment=environment) as stack:
        for token in VOTERS:
            _, token_id, secret = token.split("_")
            store(stack).tokens.create(ApiToken(token_id, secret_hash(secret), plan="development"))
        yield stack


def check(stack: LocalStack, token: str, camera: str, seed: int = 0, fx: float = 950.0) -> Answer:
    client = Client(stack)
    client.session_id = client.call("POST", "/v1/auth", token=token).json["session_id"]
    seen = held(Truth(seed=seed, fx=fx, fy=fx - 2), 3)
    views = [{"ids": ids, "points": points} for ids, points in seen]
    body = {**CAMERA, "camera": camera, "platform": PLATFORM, "views": views}
    return client.call("POST", "/v1/checks", body)


def test_five_of_one_contributor_in_a_day_are_one(stack: LocalStack) -> None:
    documents = [calibration("One who captures all day", n) for n in range(5)]
    one = [d.model_copy(update={"contributor": "somebody"}) for d in documents]
    for document in one:
        store(stack).calibrations.publish(document)
    mode = mode_of(one[0])
    (found,) = store(stack).refit.now(asked(mode, "rectilinear")).models.values()
    assert found is not None
    assert (found.total, found.reason) == (1, "too_few")
    for n, document in enumerate(one[1:], 1):  # the same on five days
        other = document.model_copy(
            update={"id": document.id[:-4] + f"{n:04x}", "time": document.time + n * 86_400}
        )
        store(stack).calibrations.publish(other)
    (found,) = store(stack).refit.now(asked(mode, "rectilinear")).models.values()
    assert found is not None
    assert (found.total, found.reason, found.confirmable) == (5, "few_contributors", True)
    assert Client(stack).lookup(camera="One who captures all day").json["reason"] == "few_contributors"


def test_five_of_five_contributors_are_reliable(stack: LocalStack) -> None:
    for n in range(5):
        store(stack).calibrations.publish(calibration("Five people", n))
    mode = mode_of(calibration("Five people", 0))
    (found,) = store(stack).refit.now(asked(mode, "rectilinear")).models.values()
    assert found is not None
    assert found.calibration is not None
    assert (found.reliable, found.calibration.contributors) == (True, 5)


def test_each_contributor_has_one_vote_a_day_and_none_on_their_own_calibration(stack: LocalStack) -> None:
    camera = "Checked by three"
    state = Truth(seed=1).calibrate(Client(stack, api_token=VOTERS[0]), camera=camera, platform=PLATFORM)
    known = store(stack).consensuses
    until(lambda: len(known.of(str(state["calibration_id"]).rpartition("-")[0])) >= 4, 30)
    own = check(stack, VOTERS[0], camera).json
    assert (own["fits"], own["counted"], own["votes"]["agree"]) == ("fits", False, 0)
    first = [check(stack, VOTERS[1], camera, seed).json for seed in range(3)]
    assert [answer["votes"]["agree"] for answer in first] == [1, 1, 1]
    assert check(stack, VOTERS[2], camera).json["votes"]["agree"] == 2
    third = check(stack, "cdb_dev_local", camera).json
    assert (third["votes"]["agree"], third["calibration"]["basis"]) == (3, "checked")
    found = Client(stack).lookup(camera=camera, platform=PLATFORM)
    assert (found.status, found.json["reliable"], found.json["calibrations"]) == (200, True, 1)
