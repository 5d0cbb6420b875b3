"""Estimates in lookups that miss: always there, never stored, and led by what is stored of the camera."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from calibdb_client.cli import main
from infra.server.server import Server
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.known import C920, LINUX, consensus, fit
from tests.helpers.service.published import put, store
from tests.helpers.service.storage_calls import storage_calls
from tests.unit.client.test_priors import IMG_SIZE, jpeg

WINDOWS = "Windows NT 10.0; Win64; x64"
IPHONE = "iPhone; CPU iPhone OS 17_5 like Mac OS X"
STARTED = "Started Cam S1 (1111:0002)"
ELSEWHERE = "Elsewhere Cam E1 (1111:0003)"


def ask(stack: Server, camera: str, platform: str = LINUX, **asked: Any) -> Answer:
    return Client(stack).lookup(camera=camera, platform=platform, **asked)


def estimate(stack: Server, camera: str, platform: str = LINUX, **asked: Any) -> dict[str, Any]:
    answer = ask(stack, camera, platform, miss="ok", **asked)
    assert answer.status == 200
    assert answer.json["calibration"] is None
    likely: dict[str, Any] = answer.json["estimate"]
    low, high = likely["interval_90"]["hfov_deg"]
    assert 1 < low < likely["hfov_deg"] < high < 175
    return likely


@pytest.mark.parametrize(
    ("camera", "platform", "basis"),
    [
        ("HD Pro Webcam C920", WINDOWS, "published"),
        ("Integrated Camera (04f2:b6d0)", WINDOWS, "population"),
        ("Logitech Brand New Cam (046d:ffff)", WINDOWS, "family"),
        ("FaceTime HD Camera", "Macintosh; Intel Mac OS X 10_15_7", "population"),
        ("Back Camera", IPHONE, "family"),
        ("camera2 0, facing back", "Linux; Android 14; Pixel 6", "published"),
        ("OBS Virtual Camera", WINDOWS, "population"),
        ("GoPro HERO7 Black", "video", "published"),
        ("-", "x", "population"),
    ],
)
def test_every_camera_has_an_estimate(stack: Server, camera: str, platform: str, basis: str) -> None:
    for size in ((1280, 720), (640, 480), (720, 1280), (16, 16), (2048, 256)):
        likely = estimate(stack, camera, platform, img_size=size)
        assert likely["basis"] == basis
        assert likely["img_size"] == list(size)
        assert bool(likely["sources"]) == (basis == "published")
        (fx, _, cx), (_, fy, cy), _ = likely["camera_matrix"]
        assert fx == fy > 0
        assert (cx, cy) == ((size[0] - 1) / 2, (size[1] - 1) / 2)
        if likely["distortion_model"] == "rectilinear":
            hfov = 2 * math.degrees(math.atan(size[0] / (2 * fx)))
            assert hfov == pytest.approx(likely["hfov_deg"], abs=0.02)


def test_every_form_of_a_miss_carries_it(stack: Server) -> None:
    expected = estimate(stack, "Razer Kiyo", WINDOWS)
    redirected = ask(stack, "Razer Kiyo", WINDOWS)
    assert (redirected.status, redirected.json["estimate"]) == (307, expected)
    problem = ask(stack, "Razer Kiyo", WINDOWS, redirect=False)
    assert (problem.status, problem.json["estimate"]) == (404, expected)


def test_a_cropped_stream_has_a_wider_interval(stack: Server) -> None:
    def width(**asked: Any) -> float:
        low, high = estimate(stack, "HD Pro Webcam C920", WINDOWS, **asked)["interval_90"]["hfov_deg"]
        return float(high - low)

    assert width(resize_mode="crop-and-scale") > 2 * width()


def test_a_zoom_narrows_the_field(stack: Server) -> None:
    plain = estimate(stack, "HD Pro Webcam C920", WINDOWS)
    zoomed = estimate(stack, "HD Pro Webcam C920", WINDOWS, zoom=2.0)
    ratio = math.tan(math.radians(plain["hfov_deg"]) / 2) / math.tan(math.radians(zoomed["hfov_deg"]) / 2)
    assert ratio == pytest.approx(2.0, rel=0.01)


def test_a_phones_model_makes_it_precise(stack: Server) -> None:
    unknown = estimate(stack, "Back Camera", IPHONE)
    known = estimate(stack, "Back Camera", IPHONE, device="iPhone14,5")
    assert known["basis"] == "published"
    assert known["hfov_deg"] == pytest.approx(68.7, abs=1.5)

    def width(likely: dict[str, Any]) -> float:
        low, high = likely["interval_90"]["hfov_deg"]
        return float(high - low)

    assert width(known) < width(unknown) / 2


def test_what_the_device_reports_counts(stack: Server) -> None:
    likely = estimate(
        stack,
        "Somebody's phone 9",
        "photographs",
        img_size=(4000, 3000),
        reported={"focal_35mm": 26},
    )
    assert likely["basis"] == "device"
    assert likely["hfov_deg"] == pytest.approx(67.3, abs=3)
    assert ask(stack, C920, reported={"focal_35mm": -1}).status == 422
    assert ask(stack, C920, device="x" * 65).status == 422


def test_a_photographs_zoom_is_its_focal_length(stack: Server) -> None:
    phone = estimate(stack, "Apple iPhone 13", "photographs", img_size=(4032, 3024), zoom=5.1)
    assert phone["basis"] == "published"
    assert phone["hfov_deg"] == pytest.approx(67.0, abs=2)
    put(
        store(stack),
        consensus(
            fit((6000, 4000), 4000.0),
            camera="Canon EOS R6",
            platform="photographs",
            zoom=24.0,
            reason="too_few",
        ),
    )
    other = estimate(stack, "Canon EOS R6", "photographs", img_size=(6000, 4000), zoom=48.0)
    assert other["basis"] == "other_size"
    assert other["hfov_deg"] == pytest.approx(2 * math.degrees(math.atan(3000 / 8000)), rel=0.08)


def test_too_few_calibrations_lead(stack: Server) -> None:
    put(store(stack), consensus(fit((1280, 720), 700.0), camera=STARTED, reason="too_few"))
    likely = estimate(stack, STARTED)
    assert likely["basis"] == "calibrations"
    own = 2 * math.degrees(math.atan(640 / 700))
    low, high = likely["interval_90"]["hfov_deg"]
    assert low < own < high
    assert likely["hfov_deg"] == pytest.approx(own, rel=0.03)


def test_another_size_is_evidence(stack: Server) -> None:
    put(store(stack), consensus(fit((1280, 720), 700.0), camera=ELSEWHERE, reason="too_few"))
    likely = estimate(stack, ELSEWHERE, img_size=(640, 360))
    assert likely["basis"] == "other_size"
    assert likely["hfov_deg"] == pytest.approx(2 * math.degrees(math.atan(640 / 700)), rel=0.06)


def test_a_wrong_calibration_does_not_win_over_published_ones(stack: Server) -> None:
    put(store(stack), consensus(fit((640, 480), 2000.0), camera=C920, reason="too_few"))
    low, high = estimate(stack, C920, img_size=(640, 480))["interval_90"]["hfov_deg"]
    assert low < 53 < high


def test_a_hit_has_none_and_a_miss_reads_no_more_and_writes_nothing(stack: Server) -> None:
    put(store(stack), consensus(fit((1920, 1080), 1400.0, uncertainty=0.1), camera="Hit Cam H1 (1111:0004)"))
    hit = ask(stack, "Hit Cam H1 (1111:0004)", img_size=(1920, 1080))
    assert hit.status == 200
    assert "estimate" not in hit.json
    with storage_calls(stack) as calls:
        estimate(stack, STARTED)
    assert calls == ["Query"]


def test_a_hit_has_the_estimate_without_it_if_asked(stack: Server) -> None:
    camera = "Compared Cam K1 (1111:0005)"
    before = estimate(stack, camera, img_size=(1920, 1080))
    put(store(stack), consensus(fit((1920, 1080), 1400.0, uncertainty=0.1), camera=camera))
    with storage_calls(stack) as calls:
        hit = ask(stack, camera, img_size=(1920, 1080), estimate="always")
    assert hit.json["camera_matrix"][0][0] == 1400.0
    assert hit.json["estimate"] == before
    assert calls == ["Query"]


@pytest.mark.usefixtures("served")
def test_command_says_what_is_likely(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    photo = tmp_path / "IMG_1234.jpg"
    photo.write_bytes(jpeg(model="Phone X9"))
    assert main(["lookup", str(photo), "--no-cache"]) == 1
    printed = capsys.readouterr().out
    assert "not calibrated" in printed
    assert "device" in printed
    assert main(["lookup", str(photo), "--no-cache", "--json"]) == 1
    likely = json.loads(capsys.readouterr().out)["estimate"]
    assert likely["img_size"] == list(IMG_SIZE)
    assert likely["hfov_deg"] == pytest.approx(67.3, abs=3)


def test_a_session_of_an_identified_phone_is_that_phones(stack: Server) -> None:
    client = Client(stack)
    assert client.open(camera="Back Camera", platform=IPHONE, device="iPhone14,5").status == 201
    assert client.state()["platform"] == f"{IPHONE}; iPhone14,5"
    assert client.open(camera="Back Camera", platform=IPHONE, device="<script>").status == 422
