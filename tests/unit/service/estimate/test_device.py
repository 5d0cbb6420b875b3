"""Kind of device behind a label, and the facts about its model."""

import pytest

from calibdb.camera_key import identify
from calibdb.camera_key.system import system_of, with_device
from calibdb.estimate.device import Device, device_of
from calibdb.estimate.facts import all_facts
from calibdb.estimate.published import facts_about

WINDOWS, LINUX = "Windows NT 10.0; Win64; x64", "X11; Linux x86_64"
MAC, IOS = "Macintosh; Intel Mac OS X 10_15_7", "iPhone; CPU iPhone OS 17_5 like Mac OS X"


def device(label: str, platform: str, model: str = "") -> Device:
    said = with_device(platform, model) if model else platform
    return device_of(identify(label, said), system_of(said))


@pytest.mark.parametrize(
    ("label", "platform", "kind", "maker", "camera"),
    [
        ("HD Pro Webcam C920 (046d:082d)", LINUX, "usb_webcam", "Logitech", ""),
        ("Integrated Camera (04f2:b6d0)", WINDOWS, "laptop_builtin", "", ""),
        ("HP TrueVision HD Camera", WINDOWS, "laptop_builtin", "HP", ""),
        ("FaceTime HD Camera", MAC, "laptop_builtin", "Apple", ""),
        ("USB Camera", LINUX, "webcam", "", ""),
        ("OBS Virtual Camera", WINDOWS, "virtual", "", ""),
        ("Back Camera", IOS, "phone_rear", "Apple", "wide"),
        ("Back Ultra Wide Camera", IOS, "phone_ultrawide", "Apple", "ultrawide"),
        ("Front Camera", IOS, "phone_front", "Apple", "front"),
        ("camera2 1, facing front", "Linux; Android 14; SM-S911B", "phone_front", "Samsung", "front"),
        ("iPhone Camera", MAC, "phone_rear", "Apple", "wide"),
        ("Intel(R) RealSense(TM) Depth Camera 435i", LINUX, "depth_camera", "Intel", ""),
        ("mmal service 16.1", LINUX, "camera_module", "", ""),
        ("GoPro HERO9 Black", "video", "action", "GoPro", ""),
        ("Apple iPhone 12 Pro", "video", "phone_video", "Apple", "wide"),
        ("NIKON D90", "photographs", "photo_camera", "", ""),
    ],
)
def test_kind_maker_and_camera(label: str, platform: str, kind: str, maker: str, camera: str) -> None:
    found = device(label, platform)
    assert (found.kind, found.maker, found.camera) == (kind, maker, camera)


@pytest.mark.parametrize(
    ("label", "platform", "model", "models"),
    [
        ("HD Pro Webcam C920 (046d:082d)", LINUX, "", {"C920"}),
        ("Logi Webcam C920e", MAC, "", {"C920"}),
        ("Brio 501 (046d:0946)", WINDOWS, "", {"Brio 501"}),
        ("Logitech BRIO", WINDOWS, "", {"BRIO 4K"}),
        ("Back Camera", IOS, "iPhone14,5", {"iPhone 13", "iPhone 13 mini / iPhone 13"}),
        ("Back Camera", IOS, "", set()),
        ("Camera that one measured", LINUX, "", set()),
        ("Max S9 Camera", LINUX, "", set()),
        ("camera2 0, facing back", "Linux; Android 14; Pixel 6", "", {"Pixel 6"}),
    ],
)
def test_facts_are_about_the_model(label: str, platform: str, model: str, models: set[str]) -> None:
    assert {fact.model for fact in facts_about(all_facts(), device(label, platform, model))} == models
