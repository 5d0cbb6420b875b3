"""Names of modes."""

from collections.abc import Iterator

import pytest

from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.published import PLATFORM, asked, calibration, held, mode_of, store

CAMERA = "Two named fields of view"
FOCALS = (950.0, 760.0, 953.0, 758.0, 951.0, 759.0)


@pytest.fixture
def stack() -> Iterator[Server]:
    with Server(environment={"MIN_CALIBRATIONS": "4"}) as stack:
        yield stack


def publish(stack: Server, *names: str | None) -> str:
    for n, (fx, name) in enumerate(zip(FOCALS, names, strict=True)):
        document = calibration(CAMERA, n, fx=fx, fy=fx - 2).model_copy(update={"mode_name": name})
        store(stack).calibrations.publish(document)
    store(stack).refit.now(asked(mode_of(document), "rectilinear"))
    return document.camera_key


def group_of(stack: Server, fx: float) -> str:
    """Name of the group that fits views of a camera with this focal length, px."""
    views = [{"ids": ids, "points": points} for ids, points in held(Truth(fx=fx, fy=fx - 2, seed=7), 3)]
    found = Client(stack).lookup(camera=CAMERA, platform=PLATFORM, miss="ok", views=views).json
    assert found["estimate"]["basis"] == "views"
    return str(found["estimate"]["group"])


def shown(stack: Server, key: str) -> dict[float, str | None]:
    """Names of the groups on the camera's page, by the focal length of their first calibration."""
    client = Client(stack)
    (mode,) = client.call("GET", f"/v1/cameras/{key}").json["modes"]
    focals = {member["id"]: member["fx"] for member in mode["members"]}
    return {
        round(focals[group[0]], -2): name
        for group, name in zip(mode["groups"], mode["group_names"], strict=True)
    }


def test_group_has_the_name_that_most_of_its_contributors_gave(stack: Server) -> None:
    key = publish(stack, "Stabilisation on", "Off", "stabilisation on", None, "Zoomed", None)
    assert group_of(stack, 952.0) == "Stabilisation on"
    assert group_of(stack, 759.0) == "Off"
    assert shown(stack, key) == {1000.0: "Stabilisation on", 800.0: "Off"}


def test_groups_of_one_name_keep_their_fields_of_view(stack: Server) -> None:
    key = publish(stack, "Wide", "wide", None, None, None, None)
    assert (group_of(stack, 952.0), group_of(stack, 759.0)) == ("68°", "80°")
    assert shown(stack, key) == {1000.0: None, 800.0: None}


def test_operator_removes_a_name(stack: Server) -> None:
    key = publish(stack, "Rude", None, None, None, None, None)
    assert group_of(stack, 952.0) == "Rude"
    (named,) = (one for one in store(stack).calibrations.all() if one.mode_name)
    assert store(stack).calibrations.remove_mode_name(named.id)
    assert not store(stack).calibrations.remove_mode_name(named.id)
    store(stack).calibrations.publish(named)  # its session ends again
    assert group_of(stack, 952.0) == "68°"
    assert shown(stack, key) == {1000.0: None, 800.0: None}


def test_contributor_names_the_mode(client: Client) -> None:
    ended = Truth(seed=3).calibrate(client, camera="Named Z1", mode_name="  Linear + Horizon ", **BRIEF)
    stored = store(client.stack).calibrations.get(ended["calibration_id"])
    assert stored.mode_name == "Linear + Horizon"


@pytest.mark.parametrize("name", ["", "<b>wide</b>", "x" * 33])
def test_unfit_names_are_refused(client: Client, name: str) -> None:
    answer = client.open(mode_name=name)
    assert (answer.status, answer.fields) == (422, ["mode_name"])
