"""Under which names a camera is found, and that they all follow from the calibrations."""

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.camera_key.names import words
from calibdb.store import Calibrations, Cameras, Objects, Table
from calibdb.store.cameras import is_place
from calibdb.store.ports import Condition, Item
from tests.helpers.service.known import C920, LINUX, calibration
from tests.helpers.service.stores import with_methods

MAC = "Macintosh; Intel Mac OS X 10_15_7"
NAMED = identify("HD Pro Webcam C920", MAC)


@pytest.fixture
def calibrations(table: Table, objects: Objects) -> Calibrations:
    return Calibrations(table, objects)


@pytest.fixture
def cameras(table: Table) -> Cameras:
    return Cameras(table)


def test_a_calibration_with_a_usb_id_is_known_under_its_name_too(
    calibrations: Calibrations, cameras: Cameras
) -> None:
    calibrations.publish(calibration())
    assert cameras.known(NAMED.key).same_as == (camera_key(C920, LINUX),)
    assert cameras.known(camera_key(C920, LINUX)).same_as == ()
    calibrations.publish(calibration("Logitech HD Pro Webcam C920 (046d:0892)", number=1))
    assert len(cameras.known(NAMED.key).same_as) == 2


def test_the_search_finds_words_cut_short(calibrations: Calibrations, cameras: Cameras) -> None:
    calibrations.publish(calibration())
    calibrations.publish(calibration("Razer Kiyo (1532:0e03)", number=1))
    c920, kiyo = camera_key(C920, LINUX), camera_key("Razer Kiyo (1532:0e03)", LINUX)
    for word, keys in {
        "c920": [c920],
        "c9": [c920],
        "web": [c920],
        "046d": [c920],
        "082d": [c920],
        "logitech": [c920],  # the USB vendor: the label does not say it
        "raz": [kiyo],
        "kiy": [kiyo],
        "": [c920, kiyo],
        "920": [],
    }.items():
        assert [key for key, _ in cameras.search(word, 10, None)[0]] == keys, word
    assert cameras.search("kiyo", 10, None) == ([(kiyo, "razer kiyo")], None)


@pytest.mark.parametrize("label", ["\U00020000" * 256, "\ufdfa" * 256, "a" * 256])
def test_overlong_name_is_found_by_its_beginning(
    calibrations: Calibrations, cameras: Cameras, label: str
) -> None:
    calibrations.publish(calibration(label))
    word = words(identify(label, LINUX).name)[0]
    assert len(word) <= 64
    assert [key for key, _ in cameras.search(word, 10, None)[0]] == [camera_key(label, LINUX)]


@pytest.mark.parametrize(
    "after", ["", "x", "c920", "c920#", "kiyo#c2-a-0123456789ab", "c920#c2-A-0123456789ab"]
)
def test_invented_page_token_is_refused(after: str) -> None:
    assert not is_place("c920", after)
    assert is_place("c920", "c920e#c2-webcam-c920e-0123456789ab")
    assert not is_place("", "c920#c2-a-0123456789ab")


def test_earlier_key_leads_to_the_camera_while_its_calibration_counts(
    calibrations: Calibrations, cameras: Cameras
) -> None:
    key = "c2-hd-pro-webcam-c920-0123456789ab"
    old, older = (calibration(number=n, key=key) for n in range(2))
    for document in (old, older, calibration(number=2)):
        calibrations.publish(document)
    calibrations.withdraw(old, "a test", 0)
    assert cameras.known(key).same_as
    calibrations.withdraw(older, "a test", 0)
    assert cameras.known(key).same_as == ()
    assert cameras.known(NAMED.key).same_as, "its name is that of the one that counts, too"
    assert len(cameras.search("c920", 10, None)[0]) == 1


def test_publishing_again_writes_no_more_than_it_must(
    calibrations: Calibrations, table: Table, objects: Objects
) -> None:
    calibrations.publish(calibration())
    written: list[object] = []

    def put(item: Item, condition: Condition | None = None) -> bool:
        written.append(item)
        return table.put(item, condition)

    Calibrations(with_methods(table, put=put), objects).publish(calibration(number=1))
    assert len(written) == 1
