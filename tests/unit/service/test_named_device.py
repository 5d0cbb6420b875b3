"""Keys of phones whose model the caller names, because no browser does."""

import pytest

from calibdb.camera_key import camera_key, identify, public_platform
from calibdb.camera_key.system import with_device
from calibdb.schema import LookupRequest

MAC = "Macintosh; Intel Mac OS X 10_15_7"
IPHONE = "iPhone; CPU iPhone OS 17_5 like Mac OS X"


def test_identified_iphones_are_told_apart() -> None:
    plain = identify("Back Camera", IPHONE)
    assert plain.ambiguous
    named = [identify("Back Camera", f"{IPHONE}; {model}") for model in ("iPhone14,5", "iPhone17,3")]
    assert not any(each.ambiguous for each in named)
    assert len({plain.key, *(each.key for each in named)}) == 3
    later = identify("Back Camera", "iPhone; CPU iPhone OS 18_1 like Mac OS X; IPHONE14,5")
    assert later.key == named[0].key
    assert identify("Front Camera", f"{IPHONE}; iPhone14,5").key != named[0].key
    assert public_platform(f"{IPHONE}; iPhone14,5") == f"{IPHONE}; iPhone14,5"
    assert public_platform(f"{IPHONE}; Annas iPhone14,5") != f"{IPHONE}; Annas iPhone14,5"


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


def test_device_is_spelled_as_the_platform_is() -> None:
    request = LookupRequest.model_validate(
        {"camera": "0", "platform": "0", "img_size": [16, 16], "device": "0\U0002f800"}
    )
    assert request.platform == "0; 0\u4e3d"
    assert LookupRequest.model_validate_json(request.model_dump_json()) == request
