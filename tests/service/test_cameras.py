"""The database as it is browsed."""

import json
from collections import Counter
from itertools import pairwise
from typing import Any
from urllib.parse import quote

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.schema import GroupsDocument
from calibdb.store import Store
from infra.server.server import Server, variables_set
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.known import C920, LINUX, calibration, consensus, fit
from tests.helpers.service.published import put
from tests.helpers.service.storage_calls import storage_calls


@pytest.fixture(scope="module", autouse=True)
def known(store: Store) -> None:
    store.calibrations.publish(calibration())
    put(
        store,
        consensus(fit((1280, 720), uncertainty=0.1)),
        consensus(fit((640, 360), 475.0, uncertainty=0.1)),
    )


def browse(stack: Server, query: str) -> Answer:
    return Client(stack).call("GET", "/v1/cameras", query=query)


def labels(stack: Server, query: str) -> list[str]:
    return [camera["camera"] for camera in browse(stack, query).json["cameras"]]


def add(store: Store, label: str, number: int = 0, **of: Any) -> None:
    store.calibrations.publish(calibration(label, number=number))
    put(store, consensus(camera=label, **of))


FEW: dict[str, Any] = {"reason": "too_few", "calibrations": 1}


def test_search_finds_a_camera_by_any_of_its_words(stack: Server) -> None:
    for query in ("logitech C920", "webc c9", "046d:082d", "HD Pro C920"):
        assert labels(stack, f"query={quote(query)}") == [C920], query
    found = browse(stack, "query=c920").json
    assert found["next"] is None
    assert labels(stack, "query=c920+kiyo") == []
    sizes = found["cameras"][0]["sizes"]
    assert [(s["img_size"], s["zoom"], s["models"], s["reliable"]) for s in sizes] == [
        ([1280, 720], 0, ["rectilinear"], True),
        ([640, 360], 0, ["rectilinear"], True),
    ]


def test_search_tells_how_many_calibrations_are_missing(stack: Server, store: Store) -> None:
    label = "Missing X3 (046d:0a03)"
    add(store, label, reason="too_few", calibrations=2)
    (found,) = browse(stack, "query=missing").json["cameras"]
    assert (found["usb_id"], found["vendor"]) == ("046d:0a03", "Logitech, Inc.")
    (size,) = found["sizes"]
    assert (size["agreeing"], size["required"], size["fx"]) == (2, 5, 950.0)
    assert size["uncertainty"] == 0.2
    assert labels(stack, "query=missing&reliable=true") == []
    assert labels(stack, "query=missing&reliable=false") == [label]


def test_camera_without_a_consensus_is_not_shown_half(stack: Server, store: Store) -> None:
    """Between the end of a capture and its consensus there is a normalised name, and nothing else to show."""
    label = "FaceTime Fresh Z8 (1111:00f8)"
    store.calibrations.publish(calibration(label))
    assert labels(stack, "query=fresh") == []
    put(store, consensus(camera=label, **FEW))
    assert labels(stack, "query=fresh") == [label]


def test_list_of_all_cameras_leaves_the_simulated_out(stack: Server, store: Store) -> None:
    label = "calibDB virtual camera 8b0a5c1f"
    add(store, label, **FEW)
    for query in ("limit=50", "limit=1"):
        assert label not in labels(stack, query)
    assert labels(stack, "query=virtual") == [label]


def test_badge_needs_no_credential_and_is_a_picture_whatever_is_asked(stack: Server) -> None:
    key = camera_key(C920, LINUX)
    for path, says in {
        f"{key}/1280x720.svg": "calibrated ± ",
        f"{key}/anything": "not calibrated",
        "%3Cscript%3E/1280x720.svg": "not calibrated",
    }.items():
        answer = Client(stack).call("GET", f"/badge/{path}")
        assert (answer.status, answer.headers["content-type"]) == (200, "image/svg+xml"), path
        assert says in answer.body.decode(), path
        assert answer.headers["cache-control"] == "public, max-age=300"


def test_public_search_needs_two_contributors(stack: Server, store: Store) -> None:
    label, other = "Visit X9 (1111:0009)", "Visit Y9 (1111:000a)"
    add(store, label, **FEW)
    add(store, other, 1, reason="too_few", calibrations=2)
    assert sorted(labels(stack, "query=visit")) == [label, other]
    with variables_set({"MIN_CONTRIBUTORS": "3"}):
        assert labels(stack, "query=visit") == [other]
        assert label not in labels(stack, "limit=50")


@pytest.mark.parametrize(
    ("said", "expected_reason"), [("wrong: seen in a mirror", "wrong"), ("Anna asked", "other")]
)
def test_a_withdrawn_calibration_is_gone(
    stack: Server, store: Store, said: str, expected_reason: str
) -> None:
    document = calibration(f"Gone {expected_reason} Z1", number=7)
    store.calibrations.publish(document)
    assert Client(stack).calibration(document.id).status == 200
    store.calibrations.withdraw(document, said, 0)
    for query in ("", "format=ros"):
        answer = Client(stack).calibration(document.id, query)
        assert (*answer.problem, answer.json["reason"]) == (410, "withdrawn", expected_reason)
        assert "Anna" not in json.dumps(answer.json)


def test_a_search_continues_after_a_page(stack: Server, store: Store) -> None:
    paged = [f"Paged Y{number}00 (2222:00{number:02x})" for number in range(2)]
    for number, label in enumerate(paged):
        add(store, label, number)
    first = browse(stack, "query=paged&limit=1").json
    rest = labels(stack, f"query=paged&limit=1&after={quote(first['next'])}")
    assert sorted([first["cameras"][0]["camera"], *rest]) == paged


@pytest.mark.parametrize("query", ["limit=0", "limit=51", "query=c920&after=x", "query=" + "x" * 129])
def test_malformed_search_is_refused_by_field(stack: Server, query: str) -> None:
    assert browse(stack, query).fields


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
    detail = Client(stack).call("GET", f"/v1/cameras/{key}").json
    assert (detail["key"], detail["camera"], detail["platform"]) == (key, label, LINUX)
    (mode,) = detail["modes"]
    assert (mode["img_size"], mode["zoom"], mode["calibrations"], mode["reason"]) == ([1280, 720], 0, 5, None)
    assert mode["groups"] == [list(group), [documents[5].id]]
    assert mode["consensus"]["rectilinear"]["reliable"] is True
    members = mode["members"]
    assert [m["id"] for m in members] == [d.id for d in documents[::-1]]
    assert [m["in_group"] for m in members] == [False, *[True] * 5]
    values = [members[0][name] for name in ("fx", "fy", "cx", "cy", "rms", "model")]
    assert values == [950.0, 950.0, 639.5, 359.5, 0.2, "rectilinear"]
    assert "contributor 0" not in json.dumps(detail)


def test_earlier_keys_and_name_keys_lead_to_the_camera(stack: Server, store: Store) -> None:
    label, old = "Older X7 (1111:0007)", "c1-older-x7-0123456789ab"
    store.calibrations.publish(calibration(label, key=old))
    put(store, consensus(camera=label))
    client, key = Client(stack), camera_key(label, LINUX)
    for asked in (key, old, identify(label, LINUX).name_key):
        assert client.call("GET", f"/v1/cameras/{asked}").json["key"] == key
    for asked in (f"{old}~1280x720~0~rectilinear", f"{old}-{0:020x}"):
        assert client.calibration(asked).json["camera"] == label


def test_best_known_of_many_sizes_are_shown_by_two_reads_each(stack: Server, store: Store) -> None:
    camera = "Many sizes Z77 (1111:0077)"
    small, often = (320, 240), (336, 240)
    for size in (small, often):
        store.calibrations.publish(calibration(camera, of=fit(size)))
    put(store, consensus(fit(small), camera=camera))
    put(store, consensus(fit(often), camera=camera, reason="too_few", calibrations=4))
    for n in range(98):
        put(store, consensus(fit((1280 + 16 * n, 720)), camera=camera, **FEW))
    browse(stack, "limit=1")  # the token is remembered from here on
    with storage_calls(stack) as asked:
        modes = Client(stack).call("GET", f"/v1/cameras/{camera_key(camera, LINUX)}").json["modes"]
    assert Counter(asked) == {"GetItem": 1 + 60, "Query": 1 + 60}
    sizes = [tuple(mode["img_size"]) for mode in modes]
    assert len(sizes) == 60
    assert {small, often} <= set(sizes)
    assert all(a[0] * a[1] >= b[0] * b[1] for a, b in pairwise(sizes)), "the largest first"


@pytest.mark.parametrize("key", ["c2-nobody-0123456789ab", "..", "%00"])
def test_uncalibrated_camera_is_not_found(stack: Server, key: str) -> None:
    assert Client(stack).call("GET", f"/v1/cameras/{key}").status == 404
