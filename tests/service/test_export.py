"""Calibrations as other tools' files, over HTTP."""

import json
import re

import numpy as np
import pytest
import yaml

from calibdb.lookup.badge import rough
from calibdb.schema import FORMATS, RefitRequest
from calibdb.store import StreamMode
from calibdb.store.keys import consensus_id
from calibsolver import Camera, formats
from calibsolver.formats.reading import read
from functions.export import app as export
from infra.server.server import Server
from tests.aws.emulator.events import Request, to_event
from tests.helpers.service import published
from tests.helpers.service.client import BRIEF, TOKEN, Client, Truth
from tests.helpers.service.in_process import request

JOBS = False


@pytest.fixture(scope="module")
def calibration(stack: Server) -> str:
    name: str = Truth(seed=3).calibrate(Client(stack), **BRIEF)["calibration_id"]
    return name


def test_stored_calibration_and_consensus_have_a_covariance(
    stack: Server, client: Client, calibration: str
) -> None:
    one = client.call("GET", f"/v1/calibrations/{calibration}", token=TOKEN).json
    covariance = np.array(one["covariance"])
    assert covariance.shape == (9, 9)
    np.testing.assert_array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance)[0] > 0
    assert "covariance" not in one["report"]
    std = one["report"]["std"]
    stated = [std["fx"], std["fy"], std["cx"], std["cy"], *std["distortion"]]
    np.testing.assert_allclose(np.sqrt(np.diagonal(covariance)), stated, rtol=0.005)
    store = published.store(stack)
    mode = StreamMode(one["camera_key"], (1280, 720), 0.0)
    store.refit.now(RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom))
    name = consensus_id(mode.camera_key, mode.img_size, mode.zoom, "rectilinear")
    pooled = np.array(client.call("GET", f"/v1/calibrations/{name}", token=TOKEN).json["covariance"])
    np.testing.assert_allclose(np.diagonal(pooled), np.diagonal(covariance), rtol=0.5)


PAGES = {"/result/": "A camera calibration: ", "/de/result/": "Eine Kamerakalibrierung: "}


def heads(page: str) -> tuple[list[str], list[str]]:
    """Return the titles and the descriptions of a page."""
    titles = re.findall(r'(?:<title[^>]*>|property="og:title" content=")([^<"]*)', page)
    described = [
        re.search(r' content="([^"]*)"', meta)[1]
        for meta in re.findall(r'<meta [^>]*\b(?:name="description"|property="og:description")[^>]*>', page)
    ]
    return titles, described


@pytest.mark.parametrize(("path", "language"), PAGES.items())
def test_page_of_a_shared_result_has_its_title(
    stack: Server, client: Client, calibration: str, monkeypatch: pytest.MonkeyPatch, path: str, language: str
) -> None:
    one = client.call("GET", f"/v1/calibrations/{calibration}", token=TOKEN).json
    plain = request(stack, "GET", path, {}, "id=nothing", b"")
    assert plain.headers["content-security-policy"]
    assert "px" not in heads(plain.body.decode())[0][0]
    served = request(stack, "GET", path, {}, f"id={calibration}", b"").body
    # The function on AWS reads the page from the site.
    addresses: list[str] = []
    monkeypatch.setattr(export, "read_file", lambda address, *_: (addresses.append(address), plain.body)[1])
    called = Request("GET", f"{path}index.html", f"id={calibration}", (), b"", "127.0.0.1")
    made = export.handler(to_event(called, "GET /result/index.html", {}, "a", 0.0), None)
    assert made["headers"]["content-type"] == "text/html; charset=utf-8"
    assert "s-maxage=60" in made["headers"]["cache-control"]
    assert [address.partition("/calibrate")[0] for address in addresses] == [
        f"{stack.environment['GUIDANCE_URL'].removesuffix('/calibrate/')}{path}index.html"
    ]
    for page in (served.decode(), made["body"]):
        titles, described = heads(page)
        assert titles == [f"Test camera · 1280 × 720 · ± {rough(one['uncertainty']['rms'])} px · calibDB"] * 2
        assert len(described) == 2
        for each in described:
            assert each.startswith(f"fx {one['camera_matrix'][0][0]:.1f} px · ")
            assert language in each


def test_the_names_are_those_of_the_solver() -> None:
    assert FORMATS == formats.FORMAT_NAMES


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_a_file_with_its_name_and_error(client: Client, calibration: str, name: str) -> None:
    answer = client.call("GET", f"/v1/calibrations/{calibration}", token=TOKEN, query=f"format={name}")
    assert answer.status == 200
    assert float(answer.headers["x-conversion-error"]) < (640 if name == "gltf" else 64)
    assert float(answer.headers["x-conversion-coverage"]) > 0.9
    if name != "calibdb":
        suffix = formats.FORMATS[name].suffix
        assert f'filename="test-camera-1280x720-{name}{suffix}"' in answer.headers["content-disposition"]
        assert answer.headers["content-type"] == formats.FORMATS[name].media_type
    warned = "x-conversion-warning" in answer.headers
    assert warned == (float(answer.headers["x-conversion-error"]) > formats.MAX_INVISIBLE_PX)


def test_a_cut_scaled_and_turned_picture_has_its_own_camera(client: Client, calibration: str) -> None:
    path = f"/v1/calibrations/{calibration}"
    whole = Camera.from_record(client.call("GET", path, token=TOKEN).json)
    query = "format=ros&crop=160,0,960,720&resize=480x360&rotate=90&mirror=1"
    data = yaml.safe_load(client.call("GET", path, token=TOKEN, query=query).body)
    assert (data["image_width"], data["image_height"]) == (360, 480)
    found = read(data).camera
    assert found is not None
    q = np.array([[500.0, 300.0], [900.0, 650.0]])
    # by hand: cut, halved about the corner of the picture, turned clockwise, mirrored
    cut = (q - (160, 0) + 0.5) / 2 - 0.5
    turned = np.stack([359 - cut[:, 1], cut[:, 0]], axis=1)
    seen = np.stack([359 - turned[:, 0], turned[:, 1]], axis=1)
    rays = whole.unproject(q)
    # mirroring after a quarter turn is a reflection about the diagonal
    assert np.abs(found.project(rays[:, [1, 0, 2]]) - seen).max() < 1e-6


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("format=visicalc", "format"),
        ("crop=1000,0,960,720", "crop"),
        ("crop=-1,0,96,72", "crop"),
        ("format=lensfun&crop=0,0,1280,1", "crop"),
        ("format=kalibr&crop=0,0,16,16", "crop"),
        ("resize=0x0", "resize"),
        ("rotate=45", "rotate"),
        ("mirror=maybe", "mirror"),
    ],
)
def test_wrong_parameters_are_refused_by_name(
    client: Client, calibration: str, query: str, field: str
) -> None:
    answer = client.call("GET", f"/v1/calibrations/{calibration}", token=TOKEN, query=query)
    assert answer.status == 422
    assert field in json.dumps(answer.json["errors"])


def test_export_without_some_views_is_refitted(client: Client, calibration: str) -> None:
    path = f"/v1/calibrations/{calibration}"
    whole = client.call("GET", path, token=TOKEN).json
    indices = [view["index"] for view in whole["report"]["views"]]
    less = client.call("GET", path, token=TOKEN, query=f"without={indices[0]}").json
    assert less["id"] is None
    assert [view["index"] for view in less["report"]["views"]] == indices[1:]
    (fx, *_), *_ = whole["camera_matrix"]
    (other, *_), *_ = less["camera_matrix"]
    assert 0 < abs(other - fx) < 4 * np.hypot(whole["report"]["std"]["fx"], less["report"]["std"]["fx"])
    assert client.call("GET", path, token=TOKEN).json == whole, "nothing of it is stored"
    file = client.call("GET", path, token=TOKEN, query=f"format=ros&without={indices[0]}")
    assert read(yaml.safe_load(file.body)).camera.matrix.tolist() == less["camera_matrix"]


@pytest.mark.parametrize("without", ["99", "0,x", ",".join(map(str, range(70)))])
def test_only_existing_views_can_be_left_out(client: Client, calibration: str, without: str) -> None:
    path = f"/v1/calibrations/{calibration}"
    answer = client.call("GET", path, token=TOKEN, query=f"without={without}")
    assert answer.status == 422
    assert [error["field"].split(".")[0] for error in answer.json["errors"]][:1] == ["without"]
    views = client.call("GET", path, token=TOKEN).json["report"]["views"]
    every = ",".join(str(view["index"]) for view in views)
    answer = client.call("GET", path, token=TOKEN, query=f"without={every}")
    assert (answer.status, answer.json["errors"][0]["field"]) == (422, "without")
