"""Labels made to deceive: what is shown and stored of them, and which camera they are."""

import pytest
from pydantic import ValidationError

from calibdb.camera_key import camera_key, public_label, public_platform
from calibdb.schema import LookupRequest

C920 = "HD Pro Webcam C920 (046d:082d)"
LINUX = "X11; Linux x86_64"
ANDROID = "Linux; Android 14; Pixel 8"
HOME, USERS = "home", "Users"  # folders of persons, apart from the paths that hold them


def test_text_behind_a_repeated_name_makes_another_camera() -> None:
    text = "HD Pro Webcam C920: HD Pro Webcam C920 <img src=//evil.example/x> RECALLED (046d:082d)"
    assert camera_key(text, LINUX) != camera_key(C920, LINUX)


@pytest.mark.parametrize(
    "text",
    ["HD Pro Webcam C920: HD Pro Webc (046d:082d)", "HD Pro Webcam C920: HD Pro Webcam C920 (046d:082d)"],
)
def test_name_that_linux_repeats_and_cuts_is_shown_once(text: str) -> None:
    assert public_label(text) == C920
    assert camera_key(text, LINUX) == camera_key(C920, LINUX)


@pytest.mark.parametrize(
    "mark",
    ["\ufe0f", "\u034f", "\u200b", "\u2060", "\u00ad", "\U000e0041", "\u180e", "\U000e0100", "\ufeff"],
)
def test_character_without_width_changes_neither_name_nor_key(mark: str) -> None:
    text = mark.join((C920[:4], C920[4:16], C920[16:]))
    assert public_label(text) == C920
    assert camera_key(text, LINUX) == camera_key(C920, LINUX)


@pytest.mark.parametrize("blank", ["\u3164", "\u2800", "\u115f", "\u1160", "\uffa0", "\u3164 \u2800"])
def test_label_of_nothing_visible_is_refused(blank: str) -> None:
    with pytest.raises(ValidationError):
        LookupRequest.model_validate({"camera": blank, "platform": LINUX, "img_size": [1280, 720]})


@pytest.mark.parametrize(
    "text",
    [
        "H\u0044 \u0420ro Webcam C920 (046d:082d)",  # Cyrillic Er
        "HD Pr\u03bf W\u0435bc\u0430m C920 (046d:082d)",  # Greek omicron, Cyrillic ie and a
        "\u041dD Pro Webcam \u0421920 (046d:082d)",
    ],
)
def test_confusable_letters_are_latin_ones(text: str) -> None:
    assert public_label(text) == C920
    assert camera_key(text, LINUX) == camera_key(C920, LINUX)


@pytest.mark.parametrize(
    ("label", "public"),
    [
        ("C:\\Users\\erika\\video.mp4", "video.mp4"),
        (f"C:/{USERS}/erika/video.mp4", "video.mp4"),
        ("\\\\server\\erika\\cam.mjpeg", "cam.mjpeg"),
        (f"/{HOME}/erika/cam.mjpeg", "cam.mjpeg"),
        ("~/erika/cam.mjpeg", "cam.mjpeg"),
        (f"file:///{HOME}/erika/cam.mjpeg", "cam.mjpeg"),
        ("Door https://erika.example/stream", "Door"),
        ("Max Mustermanns iPhone", "iPhone"),
        ("Max's iPhone 15 Pro Max", "iPhone 15 Pro Max"),
    ],
)
def test_paths_addresses_and_persons_are_not_stored(label: str, public: str) -> None:
    assert public_label(label) == public


def test_sites_address_is_no_device() -> None:
    assert public_platform("Linux; Android 14; Visit evil.example/x now 1") == "Linux; Android 14"
    for device in ("Pixel 8", "SM-G960F", "moto g(7) power", "SM-A536B Build/TP1A.220624.014"):
        assert public_platform(f"Linux; Android 14; {device}") == f"Linux; Android 14; {device}"


@pytest.mark.parametrize("field", ["camera", "platform"])
@pytest.mark.parametrize("text", [" " * 5000 + "a", "\u200b" * 5000 + "a"])
def test_long_label_is_refused_before_it_is_read(field: str, text: str) -> None:
    asked = {"camera": C920, "platform": ANDROID, "img_size": [1280, 720], field: text}
    with pytest.raises(ValidationError, match="at most 256 characters"):
        LookupRequest.model_validate(asked)
