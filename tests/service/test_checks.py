"""Checks on fresh views."""

import re
import time
from typing import Any

import numpy as np
import pytest

from calibdb import schema
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import CAMERA, TOKEN, Answer, Client, Truth, until
from tests.helpers.service.published import NOW, TILTS, calibration, mirrored, pooled, store, stored

ENVIRONMENT = {"MIN_CALIBRATIONS": "2"}  # five only take longer
JOBS = False
FLAT = ((0.01, 0.0, 0.0),)


def views(
    count: int = 3, seed: int = 100, fx: float = 950.0, tilts: Any = TILTS, sag: float = 0.0
) -> list[dict[str, Any]]:
    return published.views(Truth(fx=fx, fy=fx - 2, seed=seed, sag=sag), count, tilts)


def calibrated(stack: Server, camera: str, *which: int, begun: int = NOW, **truth: Any) -> None:
    for n in which:
        published.publish(stack, calibration(camera, n, begun=begun, **truth))


@pytest.fixture
def camera(request: pytest.FixtureRequest) -> str:
    return re.sub(r"\W+", " ", request.node.name)


@pytest.fixture
def known(stack: Server, camera: str) -> str:
    calibrated(stack, camera, 0)
    return camera


def check(stack: Server, camera: str, **body: Any) -> Answer:
    return Client(stack).check(**{"camera": camera, "views": views(), **body})


def test_three_checks_that_agree_confirm_a_single_calibration(
    stack: Server, known: str, client: Client
) -> None:
    assert client.lookup(camera=known).json["reason"] == "too_few"
    answers = [check(stack, known, views=views(seed=seed)).json for seed in range(100, 103)]
    assert [a["fits"] for a in answers] == ["fits"] * 3
    assert [a["votes"]["agree"] for a in answers] == [1, 2, 3]
    assert [a["calibration"]["reliable"] for a in answers] == [False, False, True]
    assert all(a["counted"] and a["error"] < 2 * a["expected"] for a in answers)
    found = client.lookup(camera=known)
    assert found.status == 200
    assert (found.json["calibrations"], found.json["basis"]) == (1, "checked")
    # The other models are confirmed by the same views.
    until(lambda: client.lookup(camera=known, distortion_model="rational").status == 200)


def test_checks_with_bent_boards_confirm_a_calibration(stack: Server, known: str) -> None:
    """Boards of their own bend, by up to 2 % of their length: the votes are scored in the shape of each."""
    for seed, sag in ((100, 0.1), (101, -0.16), (102, 0.13)):
        answer = check(stack, known, views=views(5, seed=seed, sag=sag)).json
        assert (answer["fits"], answer["counted"]) == ("fits", True)
        assert answer["expected"] < 0.27
        assert answer["error"] < 1.2 * answer["expected"]
    assert answer["votes"] == {"agree": 3, "disagree": 0}
    assert pooled(store(stack), calibration(known, 0)).votes.agree == 3


def test_three_failed_checks_withdraw_until_recalibration(stack: Server, camera: str, client: Client) -> None:
    calibrated(stack, camera, 0, 1)
    before = client.lookup(camera=camera)
    assert (before.status, before.json["basis"]) == (200, "consensus")
    for seed in range(3):
        answer = check(stack, camera, views=views(seed=seed, fx=980.0)).json
        assert answer["fits"] == "does_not_fit"
        assert answer["error"] > 2 * answer["expected"]
    assert answer["votes"] == {"agree": 0, "disagree": 3}
    assert client.lookup(camera=camera).json["reason"] == "disagree"
    calibrated(stack, camera, 7, begun=int(time.time()))
    assert client.lookup(camera=camera).json["calibrations"] == 3


def test_checks_of_one_session_are_one_vote(stack: Server, known: str) -> None:
    client = Client(stack)
    client.authenticate()
    body = {**CAMERA, "camera": known, "views": views()}
    first = client.call("POST", "/v1/checks", body)
    assert (first.status, first.json["votes"]) == (200, {"agree": 1, "disagree": 0})
    assert client.call("POST", "/v1/checks", body).json == first.json, "a repeated request is answered again"
    other = client.call("POST", "/v1/checks", {**body, "views": views(fx=1100.0)}).json
    assert other["fits"] == "does_not_fit"
    assert other["votes"] == {"agree": 1, "disagree": 0}, "the first one counts"


def test_pictures_of_a_calibration_are_no_independent_vote(stack: Server, known: str) -> None:
    document = calibration(known, 0)
    own = [{"ids": list(v.ids), "points": [list(p) for p in v.points]} for v in document.views]
    answer = check(stack, known, views=own)
    assert (answer.status, answer.json["fits"], answer.json["counted"]) == (200, "fits", False)
    assert check(stack, known, views=[*views(2), own[0]]).json["counted"] is False, "nor some of them"
    answer = check(stack, known)
    assert (answer.json["counted"], answer.json["votes"]["agree"]) == (True, 1)


def test_uninformative_views_confirm_nothing(stack: Server, known: str) -> None:
    answer = check(stack, known, views=views(1, tilts=FLAT)).json
    assert (answer["fits"], answer["counted"]) == ("fits", False)
    assert answer["votes"] == {"agree": 0, "disagree": 0}


def test_a_misread_corner_does_not_make_it_another_camera(stack: Server, known: str) -> None:
    seen = views(4)
    seen[1]["points"][7][0] += 25.0
    answer = check(stack, known, views=seen).json
    assert answer["fits"] == "fits"
    assert answer["error"] < 0.4


def test_changed_consensus_inherits_no_votes(stack: Server, client: Client) -> None:
    """One wrong calibration, confirmed by three; then more that are right: the three now say against it."""
    wrong = "A camera that was first mistaken for another"
    calibrated(stack, wrong, 0, fx=1100.0, fy=1098.0)
    for seed in range(100, 103):
        check(stack, wrong, views=views(seed=seed, fx=1100.0))
    assert client.lookup(camera=wrong).json["basis"] == "checked"
    calibrated(stack, wrong, 1, 2, 3, begun=int(time.time()))
    now = stored(store(stack), calibration(wrong, 0))
    assert now.total == 4
    assert abs(now.calibration.camera_matrix[0][0] - 950) < 2, "three of four agree"
    assert now.votes == schema.Votes(agree=0, disagree=0), "what was said against it was said before"
    assert now.calibration.basis == "consensus"


def test_unusable_checks_are_refused(stack: Server, known: str) -> None:
    assert check(stack, "A camera that nobody calibrated").status == 404
    assert check(stack, known, img_size=[640, 480], views=[{"ids": [0], "points": [[1, 1]]}]).status == 404
    assert check(stack, known, zoom=2).status == 404
    rng = np.random.default_rng(0)
    noise = [{"ids": list(range(40)), "points": rng.uniform(0, 700, (40, 2)).tolist()}]
    refused = [
        ([], "views"),
        ([mirrored(view) for view in views(3)], "views.0"),
        (views(6), "views"),
        (noise, "views"),
        ([{"ids": list(range(8)), "points": [[9 * n, 300] for n in range(8)]}], "views.0"),
        ([{"ids": [40], "points": [[1, 1]]}], "views.0.ids.0"),
    ]
    for seen, field in refused:
        assert check(stack, known, views=seen).fields[0] == field
    client = Client(stack)
    assert client.call("POST", "/v1/checks", {**CAMERA, "views": views()}, token=TOKEN).status == 403


@pytest.fixture
def given() -> dict[str, Any]:
    return calibration("Camera of a file", 0).answer().model_dump(mode="json")


def test_given_calibration_is_compared_without_a_vote(
    stack: Server, known: str, given: dict[str, Any]
) -> None:
    votes = stored_votes(stack)
    answer = check(stack, known, calibration=given).json
    assert answer.keys() == schema.ComparisonAnswer.model_fields.keys()
    assert (answer["fits"], answer["views"]) == ("fits", 3)
    assert answer["expected"] <= answer["error"] < 1.5 * answer["expected"]
    assert answer["drift"] < 4 * answer["drift_uncertainty"]
    larger = [[1.05 * x for x in row] for row in given["camera_matrix"][:2]]
    far = check(stack, "Unheard camera", calibration={**given, "camera_matrix": [*larger, [0, 0, 1]]}).json
    assert (far["fits"], far["expected"]) == ("does_not_fit", answer["expected"])
    assert far["error"] > 2 * far["expected"]
    assert 10 < far["drift"] < 40, "5 % of a focal length of 950 px, over an image 1280 px wide"
    assert stored_votes(stack) == votes


def stored_votes(stack: Server) -> int:
    return len(list(stack.storage.objects.names("votes/")))


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"img_size": [640, 480]}, "calibration.img_size"),
        ({"distortion_model": "fisheye"}, "calibration"),
        ({"camera_matrix": [[0, 0, 640], [0, 950, 360], [0, 0, 1]]}, "calibration.camera_matrix"),
        ({"distortion_coefficients": [0] * 15}, "calibration.distortion_coefficients"),
    ],
)
def test_unusable_calibration_is_refused_by_field(
    stack: Server, given: dict[str, Any], changed: dict[str, Any], field: str
) -> None:
    assert check(stack, "Camera of a file", calibration={**given, **changed}).fields == [field]


def test_given_nonsense_gets_an_answer(stack: Server, given: dict[str, Any]) -> None:
    given["distortion_coefficients"] = [1e300, -1e300, 0, 0, 1e300]
    assert check(stack, "Camera of a file", calibration=given).json["fits"] == "does_not_fit"


def test_check_resolves_the_camera_as_a_lookup(stack: Server) -> None:
    """Calibrated where the browser tells the USB id, checked where it does not."""
    calibrated(stack, "Acme LensCam X200 (1bcf:2c99)", 0)
    assert check(stack, "Acme LensCam X200").json["fits"] == "fits"
    assert check(stack, "Acme LensCam X300").status == 404
