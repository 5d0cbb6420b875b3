"""Calibrations as other tools' files, over HTTP."""

import re

import numpy as np
import pytest
import yaml

from calibdb.compute.exports import RIG_WRITERS
from calibdb.lookup.badge import rough
from calibdb.schema import FORMATS
from calibdb.schema.rig import RIG_FORMATS
from calibdb.store.keys import consensus_id
from calibdb_client import conversion
from calibsolver import Camera, formats
from calibsolver.formats.reading import read
from calibsolver.rig.formats import WRITERS
from functions.export import app as export
from infra.server.server import Server
from tests.aws.emulator.events import Request, to_event
from tests.helpers.service import published
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.in_process import request

JOBS = False


@pytest.fixture(scope="module")
def calibration(stack: Server) -> str:
    return Truth(seed=3).calibrate(Client(stack), **BRIEF)["calibration_id"]


def test_stored_calibration_and_consensus_have_a_covariance(
    stack: Server, client: Client, calibration: str
) -> None:
    one = client.calibration(calibration).json
    covariance = np.array(one["covariance"])
    std = one["report"]["std"]
    stated = [std["fx"], std["fy"], std["cx"], std["cy"], *std["distortion"]]
    np.testing.assert_allclose(np.sqrt(np.diagonal(covariance)), stated, rtol=0.005)
    store = published.store(stack)
    published.pooled(store, store.calibrations.get(calibration))
    name = consensus_id(one["camera_key"], (1280, 720), 0.0, "rectilinear")
    consensus = np.array(client.calibration(name).json["covariance"])
    np.testing.assert_allclose(np.diagonal(consensus), np.diagonal(covariance), rtol=0.5)


PAGE = "/de/result/"


def heads(page: str) -> tuple[list[str], list[str]]:
    titles = re.findall(r'(?:<title[^>]*>|property="og:title" content=")([^<"]*)', page)
    described = [
        re.search(r' content="([^"]*)"', meta)[1]
        for meta in re.findall(r'<meta [^>]*\b(?:name="description"|property="og:description")[^>]*>', page)
    ]
    return titles, described


def test_page_of_a_shared_result_has_its_title(
    stack: Server, client: Client, calibration: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = client.calibration(calibration).json
    plain = request(stack, "GET", PAGE, query="id=nothing")
    assert plain.headers["content-security-policy"]
    assert "px" not in heads(plain.body.decode())[0][0]
    served = request(stack, "GET", PAGE, query=f"id={calibration}").body.decode()
    # The function on AWS reads the page from the site.
    addresses = []
    monkeypatch.setattr(export, "read_file", lambda address, *_: (addresses.append(address), plain.body)[1])
    called = Request("GET", f"{PAGE}index.html", f"id={calibration}", (), b"", "127.0.0.1")
    made = export.handler(to_event(called, "GET /result/index.html"), None)
    assert made["headers"]["content-type"] == "text/html; charset=utf-8"
    assert "s-maxage=60" in made["headers"]["cache-control"]
    site = stack.environment["GUIDANCE_URL"].removesuffix("/calibrate/")
    assert addresses == [f"{site}{PAGE}index.html"]
    for page in (served, made["body"]):
        titles, described = heads(page)
        assert titles == [f"Test camera · 1280 × 720 · ± {rough(one['uncertainty']['rms'])} px · calibDB"] * 2
        assert len(described) == 2
        for each in described:
            assert each.startswith(f"fx {one['camera_matrix'][0][0]:.1f} px · ")
            assert "Eine Kamerakalibrierung: " in each


def test_the_names_are_those_of_the_solver() -> None:
    assert FORMATS == formats.FORMAT_NAMES
    assert set(RIG_WRITERS.values()) == set(WRITERS)
    assert conversion.RIG_FORMATS == RIG_FORMATS


@pytest.mark.parametrize("name", ["ros", "gltf"])
def test_file_has_its_name_type_and_error(client: Client, calibration: str, name: str) -> None:
    answer = client.calibration(calibration, f"format={name}")
    assert answer.status == 200
    form, error = formats.FORMATS[name], float(answer.headers["x-conversion-error"])
    assert (
        (error > formats.MAX_INVISIBLE_PX) == ("x-conversion-warning" in answer.headers) == (name == "gltf")
    )
    assert float(answer.headers["x-conversion-coverage"]) > 0.9
    named = f'filename="test-camera-1280x720-{name}{form.suffix}"'
    assert named in answer.headers["content-disposition"]
    assert answer.headers["content-type"] == form.media_type


def test_a_cut_scaled_and_turned_picture_has_its_own_camera(client: Client, calibration: str) -> None:
    whole = Camera.from_record(client.calibration(calibration).json)
    query = "format=ros&crop=160,0,960,720&resize=480x360&rotate=90&mirror=1"
    found = read(yaml.safe_load(client.calibration(calibration, query).body)).camera
    assert found.img_size == (360, 480)
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
        ("format=lensfun&crop=0,0,1280,1", "crop"),
        ("resize=0x0", "resize"),
        ("rotate=45", "rotate"),
        ("mirror=maybe", "mirror"),
        ("without=99", "without"),
        ("without=0,x", "without"),
    ],
)
def test_wrong_parameters_are_refused_by_name(
    client: Client, calibration: str, query: str, field: str
) -> None:
    assert client.calibration(calibration, query).fields[0].split(".")[0] == field


def test_export_without_some_views_is_refitted(client: Client, calibration: str) -> None:
    whole = client.calibration(calibration).json
    indices = [view["index"] for view in whole["report"]["views"]]
    less = client.calibration(calibration, f"without={indices[0]}").json
    assert less["id"] is None
    assert [view["index"] for view in less["report"]["views"]] == indices[1:]
    fx, other = (one["camera_matrix"][0][0] for one in (whole, less))
    assert 0 < abs(other - fx) < 4 * np.hypot(whole["report"]["std"]["fx"], less["report"]["std"]["fx"])
    assert client.calibration(calibration).json == whole, "nothing of it is stored"
    file = client.calibration(calibration, f"format=ros&without={indices[0]}")
    assert read(yaml.safe_load(file.body)).camera.matrix.tolist() == less["camera_matrix"]
    every = ",".join(map(str, indices))
    assert client.calibration(calibration, f"without={every}").fields == ["without"]
