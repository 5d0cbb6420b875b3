"""The database as it is browsed: the search, one camera, one calibration, and badges."""

import json
from urllib.parse import quote

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.schema import GroupsDocument
from calibdb.store import Store
from infra.server.server import Server, variables_set
from tests.helpers.service.client import TOKEN, Answer, Client
from tests.helpers.service.known import C920, LINUX, calibration, consensus, fit
from tests.helpers.service.published import put


@pytest.fixture(scope="module", autouse=True)
def known(store: Store) -> None:
    """A webcam of one USB id, at two sizes."""
    store.calibrations.publish(calibration())
    put(
        store,
        consensus(fit((1280, 720), uncertainty=0.1)),
        consensus(fit((640, 360), 475.0, uncertainty=0.1)),
    )


def browse(stack: Server, query: str) -> Answer:
    return Client(stack).call("GET", "/v1/cameras", token=TOKEN, query=query)


def test_search_finds_a_camera_by_any_of_its_words(stack: Server) -> None:
    for query in ("c920", "logitech C920", "logitech", "webc c9", "046d:082d", "HD Pro C920"):
        found = browse(stack, f"query={quote(query)}").json
        assert [camera["camera"] for camera in found["cameras"]] == [C920], query
        assert found["next"] is None
    assert browse(stack, "query=c920+kiyo").json["cameras"] == []
    sizes = browse(stack, "query=c920").json["cameras"][0]["sizes"]
    assert [(s["img_size"], s["zoom"], s["models"], s["reliable"]) for s in sizes] == [
        ([1280, 720], 0, ["rectilinear"], True),
        ([640, 360], 0, ["rectilinear"], True),
    ]


def test_search_tells_how_many_calibrations_are_missing(stack: Server, store: Store) -> None:
    label = "Missing X3 (046d:0a03)"
    store.calibrations.publish(calibration(label))
    put(store, consensus(camera=label, reason="too_few", calibrations=2))
    (found,) = browse(stack, "query=missing").json["cameras"]
    assert (found["usb_id"], found["vendor"]) == ("046d:0a03", "Logitech, Inc.")
    (size,) = found["sizes"]
    assert (size["agreeing"], size["required"], size["fx"]) == (2, 5, 950.0)
    assert size["uncertainty"] == 0.2
    for query, names in (("reliable=true", []), ("reliable=false", [label])):
        shown = browse(stack, f"query=missing&{query}").json["cameras"]
        assert [camera["camera"] for camera in shown] == names


def test_camera_without_a_consensus_is_not_shown_half(stack: Server, store: Store) -> None:
    """Between the end of a capture and its consensus there is a normalised name, and nothing else to show."""
    label = "FaceTime Fresh Z8 (1111:00f8)"
    store.calibrations.publish(calibration(label))
    assert browse(stack, "query=fresh").json["cameras"] == []
    put(store, consensus(camera=label, reason="too_few", calibrations=1))
    assert [camera["camera"] for camera in browse(stack, "query=fresh").json["cameras"]] == [label]


def test_list_of_all_cameras_leaves_the_simulated_out(stack: Server, store: Store) -> None:
    label = "calibDB virtual camera 8b0a5c1f"
    store.calibrations.publish(calibration(label))
    put(store, consensus(camera=label, reason="too_few", calibrations=1))
    for query in ("limit=50", "limit=1"):
        assert all(camera["camera"] != label for camera in browse(stack, query).json["cameras"])
    assert [camera["camera"] for camera in browse(stack, "query=virtual").json["cameras"]] == [label]


def test_badge_needs_no_credential_and_is_a_picture_whatever_is_asked(stack: Server) -> None:
    client, key = Client(stack), camera_key(C920, LINUX)
    for path, says in {
        f"/badge/{key}/1280x720.svg": "calibrated ± ",
        f"/badge/{key}/800x600.svg": "not calibrated",
        f"/badge/{key}/anything": "not calibrated",
        "/badge/c4-nobody-0123456789ab/1280x720.svg": "not calibrated",
        "/badge/%3Cscript%3E/1280x720.svg": "not calibrated",
    }.items():
        answer = client.call("GET", path)
        assert (answer.status, answer.headers["content-type"]) == (200, "image/svg+xml"), path
        assert says in answer.body.decode(), path
        assert "<script" not in answer.body.decode()
        assert answer.headers["cache-control"] == "public, max-age=300"
        assert answer.headers["x-content-type-options"] == "nosniff"
    assert client.call("POST", f"/badge/{key}/1280x720.svg").status == 405


def test_public_search_needs_two_contributors(stack: Server, store: Store) -> None:
    label = "Visit X9 (1111:0009)"
    store.calibrations.publish(calibration(label))
    put(store, consensus(camera=label, reason="too_few", calibrations=1))
    other = "Visit Y9 (1111:000a)"
    store.calibrations.publish(calibration(other, number=1))
    put(store, consensus(camera=other, reason="too_few", calibrations=2))
    found = [camera["camera"] for camera in browse(stack, "query=visit").json["cameras"]]
    assert sorted(found) == [label, other]
    with variables_set({"MIN_CONTRIBUTORS": "3"}):
        for query in ("query=visit", "limit=50"):
            found = [camera["camera"] for camera in browse(stack, query).json["cameras"]]
            assert other in found
            assert label not in found


@pytest.mark.parametrize(("said", "told"), [("wrong: seen in a mirror", "wrong"), ("Anna asked", "other")])
def test_a_withdrawn_calibration_is_gone(stack: Server, store: Store, said: str, told: str) -> None:
    document = calibration(f"Gone {told} Z1", number=7)
    store.calibrations.publish(document)
    path = f"/v1/calibrations/{document.id}"
    assert Client(stack).call("GET", path, token=TOKEN).status == 200
    store.calibrations.withdraw(document, said, 0)
    for query in ("", "format=ros"):
        answer = Client(stack).call("GET", path, token=TOKEN, query=query)
        assert (answer.status, answer.json["reason"]) == (410, told)
        assert answer.json["type"].endswith("#withdrawn")
        assert "Anna" not in json.dumps(answer.json)


def test_a_search_continues_after_a_page(stack: Server, store: Store) -> None:
    labels = [f"Paged Y{number}00 (2222:00{number:02x})" for number in range(2)]
    for number, label in enumerate(labels):
        store.calibrations.publish(calibration(label, number=number))
        put(store, consensus(camera=label))
    first = browse(stack, "query=paged&limit=1").json
    rest = browse(stack, f"query=paged&limit=1&after={quote(first['next'])}").json
    assert sorted(camera["camera"] for camera in first["cameras"] + rest["cameras"]) == labels


@pytest.mark.parametrize("query", ["limit=0", "limit=51", "query=c920&after=x", "query=" + "x" * 129])
def test_malformed_search_is_refused_by_field(stack: Server, query: str) -> None:
    answer = browse(stack, query)
    assert answer.status == 422
    assert answer.json["errors"]


def test_a_camera_is_shown_with_its_calibrations(stack: Server, store: Store) -> None:
    label = "Shown X6 (1111:0006)"
    key = camera_key(label, LINUX)
    documents = [calibration(label, number=number) for number in range(6)]
    for document in documents:
        store.calibrations.publish(document)
    group = tuple(document.id for document in documents[:5])
    shown = consensus(camera=label)
    groups = GroupsDocument(pooled=shown.pooled, groups=(group, (documents[5].id,)))
    assert store.consensuses.put(shown, groups, None)
    detail = Client(stack).call("GET", f"/v1/cameras/{key}", token=TOKEN).json
    assert (detail["key"], detail["camera"], detail["platform"]) == (key, label, LINUX)
    (mode,) = detail["modes"]
    assert (mode["img_size"], mode["zoom"], mode["calibrations"], mode["reason"]) == ([1280, 720], 0, 5, None)
    assert mode["groups"] == [list(group), [documents[5].id]]
    assert mode["consensus"]["rectilinear"]["reliable"] is True
    members = mode["members"]
    assert [m["id"] for m in members] == [d.id for d in documents[::-1]]
    assert [m["in_group"] for m in members] == [False, *[True] * 5]
    assert {k: members[0][k] for k in ("fx", "fy", "cx", "cy", "rms", "model")} == {
        "fx": 950.0,
        "fy": 950.0,
        "cx": 639.5,
        "cy": 359.5,
        "rms": 0.2,
        "model": "rectilinear",
    }
    assert "contributor 0" not in json.dumps(detail)


def test_earlier_keys_and_name_keys_lead_to_the_camera(stack: Server, store: Store) -> None:
    label, old = "Older X7 (1111:0007)", "c1-older-x7-0123456789ab"
    store.calibrations.publish(calibration(label, key=old))
    put(store, consensus(camera=label))
    client, key = Client(stack), camera_key(label, LINUX)
    for asked in (key, old, identify(label, LINUX).name_key):
        assert client.call("GET", f"/v1/cameras/{asked}", token=TOKEN).json["key"] == key
    consensus_of_old = client.call("GET", f"/v1/calibrations/{old}~1280x720~0~rectilinear", token=TOKEN)
    assert (consensus_of_old.status, consensus_of_old.json["camera"]) == (200, label)
    assert client.call("GET", f"/v1/calibrations/{old}-{0:020x}", token=TOKEN).status == 200


@pytest.mark.parametrize("key", ["x", "c2-nobody-0123456789ab", "..", "%00"])
def test_uncalibrated_camera_is_not_found(stack: Server, key: str) -> None:
    assert Client(stack).call("GET", f"/v1/cameras/{key}", token=TOKEN).status == 404


def test_calibration_includes_its_report(stack: Server, store: Store) -> None:
    label = "Reported X8 (1111:0008)"
    report = {"verdict": {"level": "good", "reasons": []}, "held_out": 0.3}
    stored = calibration(label).model_copy(update={"report": report})
    store.calibrations.publish(stored)
    answer = Client(stack).call("GET", f"/v1/calibrations/{stored.id}", token=TOKEN)
    assert answer.json["report"] == report
    put(store, consensus(camera=label))
    of_consensus = f"/v1/calibrations/{camera_key(label, LINUX)}~1280x720~0~rectilinear"
    assert Client(stack).call("GET", of_consensus, token=TOKEN).json["report"] is None
