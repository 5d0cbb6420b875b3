"""One camera, one key; two cameras, two."""

import csv
from collections import defaultdict

import pytest

from calibdb.camera_key import PATTERN, camera_key, public_label, public_platform
from tests.data import data_dir

LINUX, WINDOWS = "X11; Linux x86_64", "Windows NT 10.0; Win64; x64"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("HD Pro Webcam C920 (046d:082d)", LINUX), ("HD Pro Webcam C920 (046d:082d)", WINDOWS)),
        (("HD Pro Webcam C920 (046d:082d)", LINUX), ("Logitech HD Pro Webcam C920 (046D:082D)", LINUX)),
        (("Microsoft® LifeCam Studio(TM)", LINUX), ("LifeCam  Studio", LINUX)),
        (("MacBook Pro Camera (0000:0001)", "Macintosh"), ("MacBook Pro Camera", "Macintosh")),
        (
            ("FaceTime HD Camera", "Macintosh; Intel Mac OS X 10_15_7"),
            ("FaceTime HD Camera", "Macintosh; Intel Mac OS X 14_2"),
        ),
        (("Cam", f"Mozilla/5.0 ({LINUX}) Gecko/20100101 Firefox/140.0"), ("Cam", LINUX)),
        (
            ("camera2 0, facing back", "Linux; Android 14; Pixel 8"),
            ("camera2 0, facing back", "Linux; Android 15; Pixel 8"),
        ),
    ],
)
def test_the_same_camera(one: tuple[str, str], other: tuple[str, str]) -> None:
    assert camera_key(*one) == camera_key(*other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("Integrated Camera (04f2:b6d0)", LINUX), ("Integrated Camera (04f2:b2ea)", LINUX)),
        (("Integrated Camera", LINUX), ("Integrated Camera (04f2:b2ea)", LINUX)),
        (("Back Camera", "iPhone"), ("Front Camera", "iPhone")),
        (
            ("camera2 0, facing back", "Linux; Android 14; Pixel 8"),
            ("camera2 0, facing back", "Linux; Android 14; Pixel 7"),
        ),
        (("後置望遠相機", "iPhone"), ("後置雙廣角相機", "iPhone")),
        (("FaceTime HD Camera", "Macintosh"), ("FaceTime HD Camera", LINUX)),
    ],
)
def test_different_cameras(one: tuple[str, str], other: tuple[str, str]) -> None:
    assert camera_key(*one) != camera_key(*other)


@pytest.mark.parametrize(
    "label", ["x", "ÄÖÜ", "後置雙廣角相機", "a" * 256, "../../etc", "a#b~c/d?e", "\0", "-", "(046d:082d)"]
)
def test_a_key_is_safe_in_addresses_and_names(label: str) -> None:
    assert PATTERN.fullmatch(camera_key(label, LINUX))


@pytest.mark.parametrize(
    ("label", "public"),
    [
        ("Sam’s iPhone Desk View Camera", "iPhone Desk View Camera"),
        ("Sam's Galaxy S23", "Galaxy S23"),
        ("HD Pro Webcam C920 (046d:082d)", "HD Pro Webcam C920 (046d:082d)"),
        ("iPhone", "iPhone"),
    ],
)
def test_no_persons_name_is_kept(label: str, public: str) -> None:
    assert public_label(label) == public


def test_the_platform_is_what_stands_in_parentheses() -> None:
    assert public_platform(f"Mozilla/5.0 ({LINUX}) AppleWebKit/537.36") == LINUX
    assert public_platform(LINUX) == LINUX


def test_real_labels() -> None:
    """No two products share a key; labels with one USB id are one camera."""
    with (data_dir() / "labels.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["label"]]
    products, by_id = defaultdict(set), defaultdict(set)
    for row in rows:
        key = camera_key(row["label"], row["platform"] or "unknown")
        products[key].add(row["same_device_group"])
        if row["usb_vid"] and row["usb_vid"] != "0000":
            by_id[row["usb_vid"], row["usb_pid"]].add(key)
    assert len(rows) > 90
    assert {key: found for key, found in products.items() if len(found) > 1} == {}
    assert {usb_id: keys for usb_id, keys in by_id.items() if len(keys) > 1} == {}
