"""Estimates in lookups that miss."""

import math
from pathlib import Path
from typing import Any

import pytest

from calibdb_client.cli import main
from infra.server.server import Server
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.commands import run
from tests.helpers.service.known import C920, LINUX, consensus, fit
from tests.helpers.service.published import put, store
from tests.helpers.service.storage_calls import storage_calls
from tests.unit.client.test_priors import IMG_SIZE, jpeg

WINDOWS = "Windows NT 10.0; Win64; x64"
IPHONE = "iPhone; CPU iPhone OS 17_5 like Mac OS X"


def ask(stack: Server, camera: str, platform: str = LINUX, **asked: Any) -> Answer:
    return Client(stack).lookup(camera=camera, platform=platform, **asked)


def estimate(stack: Server, camera: str, platform: str = LINUX, **asked: Any) -> dict[str, Any]:
    answer = ask(stack, camera, platform, miss="ok", **asked)
    assert answer.status == 200
    assert answer.json["calibration"] is None
    likely = answer.json["estimate"]
    low, high = likely["interval_90"]["hfov_deg"]
    assert 1 < low < likely["hfov_deg"] < high < 175
    return likely


@pytest.mark.parametrize(
    ("camera", "platform", "basis"),
    [
        ("HD Pro Webcam C920", WINDOWS, "published"),
        ("Logitech Brand New Cam (046d:ffff)", WINDOWS, "family"),
        ("Back Camera", IPHONE, "family"),
        ("camera2 0, facing back", "Linux; Android 14; Pixel 6", "published"),
        ("OBS Virtual Camera", WINDOWS, "population"),
        ("GoPro HERO7 Black", "video", "published"),
        ("-", "x", "population"),
    ],
)
def test_every_camera_has_an_estimate(stack: Server, camera: str, platform: str, basis: str) -> None:
    for size in ((1280, 720), (720, 1280), (16, 16), (2048, 256)):
        likely = estimate(stack, camera, platform, img_size=size)
        assert likely["basis"] == basis
        assert likely["img_size"] == list(size)
        assert bool(likely["sources"]) == (basis == "published")
        (fx, _, cx), (_, fy, cy), _ = likely["camera_matrix"]
        assert fx == fy > 0
        assert (cx, cy) == ((size[0] - 1) / 2, (size[1] - 1) / 2)
        if likely["distortion_model"] == "rectilinear":
            assert hfov_deg(size[0], fx) == pytest.approx(likely["hfov_deg"], abs=0.02)


def width(likely: dict[str, Any]) -> float:
    low, high = likely["interval_90"]["hfov_deg"]
    return float(high - low)


def hfov_deg(width_px: float, fx: float) -> float:
    return 2 * math.degrees(math.atan(width_px / (2 * fx)))


def test_a_crop_widens_the_interval_and_a_zoom_narrows_the_field(stack: Server) -> None:
    asked = ({}, {"resize_mode": "crop-and-scale"}, {"zoom": 2.0})
    plain, cropped, zoomed = (estimate(stack, "HD Pro Webcam C920", WINDOWS, **more) for more in asked)
    assert width(cropped) > 2 * width(plain)
    ratio = zoomed["camera_matrix"][0][0] / plain["camera_matrix"][0][0]
    assert ratio == pytest.approx(2.0, rel=0.01)


def test_a_phones_model_makes_it_precise(stack: Server) -> None:
    unknown = estimate(stack, "Back Camera", IPHONE)
    known = estimate(stack, "Back Camera", IPHONE, device="iPhone14,5")
    assert known["basis"] == "published"
    assert known["hfov_deg"] == pytest.approx(68.7, abs=1.5)
    assert width(known) < width(unknown) / 2


def test_what_the_device_reports_counts(stack: Server) -> None:
    photo = {"img_size": (4000, 3000), "reported": {"focal_35mm": 26}}
    likely = estimate(stack, "Somebody's phone 9", "photographs", **photo)
    assert likely["basis"] == "device"
    assert likely["hfov_deg"] == pytest.approx(67.3, abs=3)
    assert ask(stack, C920, reported={"focal_35mm": -1}).status == 422


def test_a_photographs_zoom_is_its_focal_length(stack: Server) -> None:
    phone = estimate(stack, "Apple iPhone 13", "photographs", img_size=(4032, 3024), zoom=5.1)
    assert phone["basis"] == "published"
    assert phone["hfov_deg"] == pytest.approx(67.0, abs=2)


@pytest.mark.parametrize(
    ("known", "asked", "basis", "fx"),
    [
        ({"of": fit((1280, 720), 700.0)}, {}, "calibrations", 700.0),
        ({"of": fit((640, 360), 350.0)}, {}, "other_size", 700.0),
        ({"of": fit((1280, 720), 700.0), "zoom": 24.0}, {"zoom": 48.0}, "other_size", 1400.0),
    ],
)
def test_too_few_calibrations_lead(
    stack: Server, known: dict[str, Any], asked: dict[str, Any], basis: str, fx: float
) -> None:
    camera, platform = f"Started at {fx} {basis}", "photographs"
    put(store(stack), consensus(camera=camera, platform=platform, reason="too_few", **known))
    likely = estimate(stack, camera, platform, **asked)
    assert likely["basis"] == basis
    assert likely["hfov_deg"] == pytest.approx(hfov_deg(1280, fx), rel=0.08)


def test_a_wrong_calibration_does_not_win_over_published_ones(stack: Server) -> None:
    put(store(stack), consensus(fit((640, 480), 2000.0), camera=C920, reason="too_few"))
    low, high = estimate(stack, C920, img_size=(640, 480))["interval_90"]["hfov_deg"]
    assert low < 53 < high


def test_a_hit_has_the_estimate_without_it_only_if_asked(stack: Server) -> None:
    camera = "Compared Cam K1 (1111:0005)"
    before = estimate(stack, camera, img_size=(1920, 1080))
    put(store(stack), consensus(fit((1920, 1080), 1400.0, uncertainty=0.1), camera=camera))
    assert "estimate" not in ask(stack, camera, img_size=(1920, 1080)).json
    with storage_calls(stack) as calls:
        hit = ask(stack, camera, img_size=(1920, 1080), estimate="always")
    assert hit.json["camera_matrix"][0][0] == 1400.0
    assert hit.json["estimate"] == before
    assert calls == ["Query"]


@pytest.mark.usefixtures("served")
def test_command_says_what_is_likely(tmp_path: Path) -> None:
    photo = tmp_path / "IMG_1234.jpg"
    photo.write_bytes(jpeg(model="Phone X9"))
    assert "not calibrated" in run(main, "lookup", photo, "--no-cache", status=1).out
    likely = run(main, "lookup", photo, "--no-cache", "--json", status=1).document["estimate"]
    assert likely["img_size"] == list(IMG_SIZE)
    assert likely["hfov_deg"] == pytest.approx(67.3, abs=3)
