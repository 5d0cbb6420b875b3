"""One camera, one key; two cameras, two; and what cannot be told apart says so."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from calibdb.camera_key import PATTERN, camera_key, identify, public_label, public_platform
from calibdb.camera_key.label import public_mode_name
from calibdb.camera_key.system import with_device
from calibdb.camera_key.usb_vendors import vendor_of, vendor_words
from calibdb.camera_key.virtual import _PROGRAMS
from calibdb.schema import LookupRequest, SessionRequest
from infra.web_build.usb_vendors import TABLE, table

LINUX, WINDOWS, MAC = "X11; Linux x86_64", "Windows NT 10.0; Win64; x64", "Macintosh; Intel Mac OS X 10_15_7"
IPHONE = "iPhone; CPU iPhone OS 17_5 like Mac OS X"
ANDROID = "Linux; Android 14; Pixel 8"
C920 = "HD Pro Webcam C920 (046d:082d)"
HOME, USERS = "home", "Users"  # folders of persons, apart from the paths that hold them


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((C920, LINUX), ("Logitech HD Pro Webcam C920 (046D:082D)", LINUX)),
        (("HD Pro Webcam C920", WINDOWS), ("Logitech HD Pro Webcam C920", "Windows NT 11.0; ARM64")),
        (("Microsoft® LifeCam Studio(TM)", LINUX), ("LifeCam  Studio", LINUX)),
        (("MacBook Pro Camera (0000:0001)", MAC), ("MacBook Pro Camera", MAC)),
        (("Cam", f"Mozilla/5.0 ({LINUX}) Gecko/20100101 Firefox/140.0"), ("Cam", LINUX)),
        (("Integrated Camera", LINUX), ("Integrated Camera", "X11; Ubuntu; Linux x86_64; rv:140.0")),
        (
            ("camera2 0, facing back", ANDROID),
            ("camera 0, facing back", "Linux; Android 15; Pixel 8 Build/AP1A.240505.004"),
        ),
        # client hints, written as the user agent would
        (
            ("camera2 0, facing back", ANDROID),
            ("camera2 0, facing back", "Android; Pixel 8"),
        ),
        (("OBS Virtual Camera (m-de:vice)", MAC), ("OBS Virtual Camera", WINDOWS)),
        (("Sam’s iPhone Camera", MAC), ("Kamera von „iPhone von Anna“", MAC)),
        (("Rückseitige Kamera", IPHONE), ("Back Camera", IPHONE)),
        (("Задня камера", IPHONE), ("Back Camera", IPHONE)),
    ],
)
def test_the_same_camera(one: tuple[str, str], other: tuple[str, str]) -> None:
    assert camera_key(*one) == camera_key(*other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("Integrated Camera (04f2:b6d0)", LINUX), ("Integrated Camera (04f2:b2ea)", LINUX)),
        (("後置望遠相機", IPHONE), ("後置雙廣角相機", IPHONE)),
        (("Back Ultra Wide Camera", IPHONE), ("Back Wide Camera", IPHONE)),
        (("Back Camera", IPHONE), ("Back Camera", "iPad; CPU OS 17_5 like Mac OS X")),
        (("FaceTime HD Camera", MAC), ("FaceTime HD Camera", LINUX)),
        (("FaceTime HD Camera (Built-in)", MAC), ("FaceTime HD Camera (Display)", MAC)),
        # a maker's name is all that distinguishes these
        (("Logitech HD Webcam", WINDOWS), ("HD Webcam", WINDOWS)),
        (("Logitech Webcam C930e", WINDOWS), ("Logitech Webcam C920e", WINDOWS)),
        (("USB Camera: HD Webcam", LINUX), ("USB Camera", LINUX)),
        # one label, two lenses: translated only where nothing is left over
        (("Back Camera 2", IPHONE), ("Back Camera", IPHONE)),
        (("camera2 2, facing back", "Android; Pixel 8"), ("camera 2, facing back", "Android; Pixel 8")),
    ],
)
def test_different_cameras(one: tuple[str, str], other: tuple[str, str]) -> None:
    assert camera_key(*one) != camera_key(*other)


@pytest.mark.parametrize(
    ("label", "platform", "ambiguous"),
    [
        ("Integrated Camera (04f2:b6d0)", LINUX, False),
        ("Razer Kiyo", WINDOWS, False),
        ("camera2 0, facing back", ANDROID, False),
        ("camera2 0, facing back", "Linux; Android 10; K", True),  # what browsers say since 2023
        ("Back Dual Wide Camera", IPHONE, True),  # of which iPhone?
        ("Integrated Camera", LINUX, True),
        ("USB2.0 HD UVC WebCam", WINDOWS, True),
        ("HP TrueVision HD Camera", WINDOWS, True),
        ("unnamed camera", LINUX, True),
    ],
)
def test_generic_labels_are_not_distinct(label: str, platform: str, ambiguous: bool) -> None:
    assert identify(label, platform).ambiguous is ambiguous


@pytest.mark.parametrize(
    ("label", "virtual"),
    [
        ("OBS-Camera2", True),
        ("Dummy video device (0x0000)", True),
        ("e2eSoft VCam", True),
        ("HD Pro Webcam C920", False),
        ("Intel(R) RealSense(TM) 3D Camera Virtual Driver", False),
        ("OBSBOT Tiny 2", False),
    ],
)
def test_virtual_cameras_are_recognised(label: str, virtual: bool) -> None:
    assert identify(label, WINDOWS).virtual is virtual


PHONE = "Apple iPhone 15 Pro, iPhone 15 Pro back triple camera"


def test_exif_make_and_model_are_distinct() -> None:
    wide, far = f"{PHONE} 6.765mm f/1.78", f"{PHONE} 9mm f/2.8"
    assert public_label(wide) == wide.replace(",", "")
    photograph = identify(wide, "photographs")
    assert not photograph.ambiguous
    others = [(far, "photographs"), (wide, "video"), (wide, LINUX), (wide.replace("15", "14"), "photographs")]
    assert photograph.key not in {camera_key(*other) for other in others}
    reflex = "Canon EOS R5, RF24-105mm F4 L IS USM"
    assert not identify(reflex, "photographs").ambiguous
    assert camera_key(reflex, "photographs") != camera_key(reflex, WINDOWS)
    assert identify("Camera", "photographs").ambiguous


def test_own_virtual_camera_is_distinct() -> None:
    identity = identify("calibDB virtual camera 1f2e3d4c", LINUX)
    assert (identity.virtual, identity.ambiguous) == (False, False)
    assert identity.key != camera_key("calibDB virtual camera 1f2e3d4d", LINUX)


@pytest.mark.parametrize(
    ("label", "public"),
    [
        ("Anna Desk View Camera", "Desk View Camera"),
        ("Sam's Galaxy S23", "Galaxy S23"),
        ("Kamera von „Annas iPhone“", "Kamera iPhone"),
        ("Appareil photo de « iPhone de Zoé »", "Appareil photo iPhone"),
        ("太郎のiPhone 15 Proのカメラ", "iPhone 15 Pro カメラ"),
        ("iPhone (Иван) камера", "iPhone камера"),
        ("Anna's S23 (Windows Virtual Camera)", "Windows Virtual Camera"),
        ("Anna Schmidt’s Nothing Phone (2)", "Nothing Phone (2)"),
        ("Anna Schmidts Galaxy S21", "Galaxy S21"),
        ("Webcam of Anna Schmidt", "Webcam"),
        ("Камера від Анни", "Камера"),
        ("Cámara de Anna", "Cámara"),
        ("Kamera „Anna“", "Kamera"),
        ("Logitech C920 (Anna Schmidt) (046d:082d)", "Logitech C920 (046d:082d)"),
        ("Logitech C920 anna.schmidt@example.com 10.0.0.5", "Logitech C920"),
        ("ANNA-SCHMIDT-PC Camera", "Camera"),
        ("DroidCam Source anna-pc", "DroidCam"),
        ("Anna's", "camera"),
        ("Galaxy S23 von Anna", "Galaxy S23"),
        ("iPhone 15 Pro 0170 1234567 Camera", "iPhone 15 Pro Camera"),
        ("Galaxy S21 (0170-1234567) (046d:082d)", "Galaxy S21 (046d:082d)"),
        ("+49 (0) 170 / 123 45 67 Webcam", "Webcam"),
        ("Logitech C920 (555) 123-4567", "Logitech C920"),
        ("Webcam ０１７０ １２３４５６７", "Webcam"),
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
def test_no_persons_name_or_address_is_kept(label: str, public: str) -> None:
    assert public_label(label) == public


@pytest.mark.parametrize(
    "label",
    [
        "Camera 1732233445",
        "Lens 0.45 0.30 0.22 1.5 f/2.8 24-105mm",
        "USB Camera-B4.09.24.1 1920x1080 60",
        "SNC-0102-03-04 05 06",
        "FaceTime HD Camera (Built-in) (05ac:8510)",
        "Fotocamera di Panoramica Scrivania",
        "Wide Field of View Camera",
        "USB2.0 HD UVC/WebCam",
        "Фронтальна камера",
        "摄像头 1",
    ],
)
def test_label_without_personal_data_stays(label: str) -> None:
    assert public_label(label) == label


def test_control_characters_are_removed() -> None:
    assert public_label("X\x1b[31m Z77\u202e\nexe\x07") == "X [31m Z77 exe"
    assert public_platform("X11;\x1b Linux\u202e x86_64\n") == LINUX


@pytest.mark.parametrize("name", sorted(_PROGRAMS))
def test_a_programs_name_is_the_programs(name: str) -> None:
    shown = public_label(f"Anna's {name.title()}")
    assert name.title().startswith(shown.strip())
    assert (identify(shown, WINDOWS).virtual, identify(shown, WINDOWS).name) == (True, name)


@pytest.mark.parametrize(
    ("platform", "public"),
    [
        (f"Mozilla/5.0 ({LINUX}) AppleWebKit/537.36", LINUX),
        ("anna.schmidt@example.com 10.0.0.5", "other"),
        ("Linux anna@example.com; 10.0.0.5", "Linux"),
        ("Linux; Android 14; Anna Schmidt", "Linux; Android 14"),
        ("Linux; Android 14; Handy 0170 1234567", "Linux; Android 14"),
        ("Windows of Anna", "Windows"),
        ("Linux; Android 14; Visit evil.example/x now 1", "Linux; Android 14"),
        (f"{IPHONE}; Annas iPhone14,5", f"{IPHONE}; iOS"),
        *(
            (platform, platform)
            for platform in (
                *(WINDOWS, MAC, IPHONE, "X11; Ubuntu; Linux x86_64; rv:140.0", "photographs"),
                "Linux; Android 15; Pixel 8 Build/AP1A.240505.004",
                "Linux; Android 14; moto g power (2022)",
                *("Linux; Android 13; 2201117TG", f"{IPHONE}; iPhone14,5"),
            )
        ),
    ],
)
def test_platform_keeps_recognised_parts(platform: str, public: str) -> None:
    assert public_platform(platform) == public


PARTS = "Sam's |iPhone| von |Anna|’s |(|)|@x|OBS | of |10.0.0.5|+49 170| 1234567|Camera|(046d:082d)|Logitech "
TEXT = st.text(max_size=60) | st.lists(
    st.sampled_from([*PARTS.split("|"), "C920", "®", ": ", "後置", " ", "2"]), max_size=8
).map("".join)


@given(
    label=TEXT,
    platform=st.sampled_from([LINUX, MAC, IPHONE, ANDROID]) | st.text(max_size=40),
)
def test_stored_label_gives_the_same_key(label: str, platform: str) -> None:
    """The index is rebuilt from what is stored, which carries no person's name."""
    label_, platform_ = public_label(label), public_platform(platform)
    assert identify(label_, platform_) == identify(label, platform)
    assert (public_label(label_), public_platform(platform_)) == (label_, platform_)
    assert PATTERN.fullmatch(camera_key(label, platform)), "it is safe in addresses and names"


def test_a_distinct_name_leads_to_its_usb_id_from_every_computer() -> None:
    with_id = identify(C920, LINUX)
    for platform in (LINUX, WINDOWS, MAC, "X11; CrOS x86_64 14541.0.0", "curl/8"):
        assert camera_key("HD Pro Webcam C920", platform) in with_id.name_keys
    assert camera_key("HD Pro Webcam C920", ANDROID) not in with_id.name_keys
    built_in = identify("Integrated Camera (04f2:b6d0)", LINUX)
    assert built_in.name_keys == {camera_key("Integrated Camera", LINUX)}


def test_text_behind_a_repeated_name_makes_another_camera() -> None:
    text = "HD Pro Webcam C920: HD Pro Webcam C920 <img src=//evil.example/x> RECALLED (046d:082d)"
    assert camera_key(text, LINUX) != camera_key(C920, LINUX)


ZERO_WIDTH = "\ufe0f\u034f\u200b\u2060\u00ad\U000e0041\u180e\U000e0100\ufeff"


@pytest.mark.parametrize(
    "text",
    [
        # Linux' driver repeats the name, and cuts it.
        "HD Pro Webcam C920: HD Pro Webc (046d:082d)",
        "HD Pro Webcam C920: HD Pro Webcam C920 (046d:082d)",
        *(mark.join((C920[:4], C920[4:16], C920[16:])) for mark in ZERO_WIDTH),
        "H\u0044 \u0420ro Webcam C920 (046d:082d)",  # Cyrillic Er
        "HD Pr\u03bf W\u0435bc\u0430m C920 (046d:082d)",  # Greek omicron, Cyrillic ie and a
        "\u041dD Pro Webcam \u0421920 (046d:082d)",
    ],
)
def test_disguised_label_has_the_plain_name_and_key(text: str) -> None:
    assert public_label(text) == C920
    assert camera_key(text, LINUX) == camera_key(C920, LINUX)


@pytest.mark.parametrize("blank", ["\u3164", "\u2800", "\u115f", "\u1160", "\uffa0"])
def test_label_of_nothing_visible_is_refused(blank: str) -> None:
    with pytest.raises(ValidationError):
        LookupRequest.model_validate({"camera": blank, "platform": LINUX, "img_size": [1280, 720]})


@pytest.mark.parametrize("field", ["camera", "platform"])
@pytest.mark.parametrize("text", [" " * 5000 + "a", "\u200b" * 5000 + "a"])
def test_long_label_is_refused_before_it_is_read(field: str, text: str) -> None:
    asked = {"camera": C920, "platform": ANDROID, "img_size": [1280, 720], field: text}
    with pytest.raises(ValidationError, match="at most 256 characters"):
        LookupRequest.model_validate(asked)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        *(
            (name, name)
            for name in ("78°", "4K, 16:9", "Linear + Horizon", "Стабілізація", "2.7K EIS", "crop 50%")
        ),
        ("  wide \u200b angle\n", "wide angle"),
        ("Anna’s wide", "wide"),
        ("wide mail@example.org", "wide"),
        ("wide +49 170 1234567", "wide"),
        ("https://example.org/wide", ""),
        ("<script>", ""),
        ("x" * 33, ""),
        ("serial 123456", ""),
    ],
)
def test_mode_name_is_of_settings_only(name: str, shown: str) -> None:
    assert public_mode_name(name) == shown


def test_identified_iphones_are_told_apart() -> None:
    plain = identify("Back Camera", IPHONE)
    assert plain.ambiguous
    named = [identify("Back Camera", f"{IPHONE}; {model}") for model in ("iPhone14,5", "iPhone17,3")]
    assert not any(each.ambiguous for each in named)
    assert len({plain.key, *(each.key for each in named)}) == 3
    later = identify("Back Camera", "iPhone; CPU iPhone OS 18_1 like Mac OS X; IPHONE14,5")
    assert later.key == named[0].key
    assert identify("Front Camera", f"{IPHONE}; iPhone14,5").key != named[0].key


@pytest.mark.parametrize(
    ("platform", "device", "joined"),
    [
        (IPHONE, "iPhone14,5", f"{IPHONE}; iPhone14,5"),
        (f"{IPHONE}; iPhone14,5", "iphone14,5", f"{IPHONE}; iPhone14,5"),
        (f"Mozilla/5.0 ({IPHONE}) AppleWebKit/605.1", "iPhone14,5", f"{IPHONE}; iPhone14,5"),
        ("Linux; Android 10; K", "SM-S911B", "Linux; Android 10; K; SM-S911B"),
    ],
)
def test_device_joins_the_platform(platform: str, device: str, joined: str) -> None:
    assert with_device(platform, device) == joined


def test_device_of_a_tablet_that_poses_as_a_computer() -> None:
    identity = identify("Back Camera", with_device(MAC, "iPad14,3"))
    assert not identity.ambiguous
    assert identity.key == camera_key("Back Camera", "iPad; CPU OS 17_5 like Mac OS X; iPad14,3")


@pytest.mark.parametrize("model", [LookupRequest, SessionRequest])
def test_device_is_spelled_as_the_platform_is(model: type[LookupRequest | SessionRequest]) -> None:
    asked = {"camera": "0", "platform": "0", "img_size": [16, 16]}
    request = model.model_validate_json(json.dumps({**asked, "device": "0\U0002f800"}))
    assert request.platform == "0; 0\u4e3d"
    assert model.model_validate_json(request.model_dump_json()) == request
    with pytest.raises(ValidationError):
        model.model_validate_json(json.dumps({**asked, "device": "<script>"}))


EXCERPT = """\
# Version: 2020.01.02
046d  Logitech, Inc.
\t082d  HD Pro Webcam C920
\t\t01  an interface
045e  Microsoft Corp.
C 00  (Defined at Interface level)
"""


def test_vendors_of_webcams_are_known() -> None:
    found = {usb_id: vendor_of(usb_id) for usb_id in ("046d:082d", "04f2:b6d9", "045e:0779")}
    assert found == {
        "046d:082d": "Logitech, Inc.",
        "04f2:b6d9": "Chicony Electronics Co., Ltd",
        "045e:0779": "Microsoft Corp.",
    }
    assert vendor_of("0000:0001") is None
    assert vendor_of(None) is None


def test_words_of_vendors_are_names_and_no_legal_forms() -> None:
    assert vendor_words("046d:082d") == ["logitech"]
    assert vendor_words("04f2:b6d9") == ["chicony"]
    assert vendor_words(None) == []


def test_table_is_made_of_the_lines_of_vendors() -> None:
    lines = table(EXCERPT).splitlines()
    assert [line for line in lines if not line.startswith("#")] == [
        "045e Microsoft Corp.",
        "046d Logitech, Inc.",
    ]
    assert "version 2020.01.02" in lines[0]
    with pytest.raises(ValueError, match="no version, or no vendors"):
        table("<html>")


def test_stored_table_has_all_vendors_once_and_in_order() -> None:
    ids = [line[:4] for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert ids == sorted(set(ids))
    assert len(ids) > 3000
