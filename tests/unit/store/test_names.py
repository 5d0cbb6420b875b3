"""Under which names a camera is found, and that they all follow from the calibrations."""

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.camera_key.names import words
from calibdb.store import Calibrations, Cameras, Objects, Table
from calibdb.store.cameras import is_place
from calibdb.store.ports import Condition, Item
from tests.helpers.service.known import LINUX, calibration
from tests.helpers.service.stores import with_methods

MAC = "Macintosh; Intel Mac OS X 10_15_7"
NAMED = identify("HD Pro Webcam C920", MAC)


@pytest.fixture
def cameras(table: Table) -> Cameras:
    return Cameras(table)


@pytest.mark.parametrize("label", ["\U00020000" * 256, "\ufdfa" * 256])
def test_overlong_name_is_found_by_its_beginning(
    calibrations: Calibrations, cameras: Cameras, label: str
) -> None:
    calibrations.publish(calibration(label))
    word = words(identify(label, LINUX).name)[0]
    assert len(word) <= 64
    assert [key for key, _ in cameras.search(word, 10, None)[0]] == [camera_key(label, LINUX)]


@pytest.mark.parametrize("after", ["", "c920#", "kiyo#c2-a-0123456789ab", "c920#c2-A-0123456789ab"])
def test_invented_page_token_is_refused(after: str) -> None:
    assert not is_place("c920", after)
    assert is_place("c920", "c920e#c2-webcam-c920e-0123456789ab")
    assert not is_place("", "c920#c2-a-0123456789ab")


def items(table: Table) -> dict[tuple[str, str], Item | None]:
    return {key: table.get(*key) for key in table.keys("C")}


def test_the_index_made_anew_has_the_same_names(
    calibrations: Calibrations, table: Table, objects: Objects
) -> None:
    documents = [
        calibration(),
        calibration("HD Pro Webcam C920", MAC, number=1),
        calibration("Logitech HD Pro Webcam C920 (046d:082d)", number=2),
        calibration("Integrated Camera (04f2:b6d0)", number=3),
        calibration("後置雙廣角相機", "iPhone; CPU iPhone OS 17_5 like Mac OS X", number=4),
        calibration("OBS Virtual Camera", number=5),
        calibration(key="c1-hd-pro-webcam-c920-0123456789ab", number=6),
    ]
    for document in documents:
        calibrations.publish(document)
    before = items(table)
    for pk, sk in before:
        table.delete(pk, sk)
    anew = Calibrations(table, objects)
    for document, withdrawn in reversed(list(anew.everything())):
        anew.index(document, withdrawn=withdrawn)
    assert items(table) == before


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


def test_earlier_label_is_shown_by_current_rules(calibrations: Calibrations) -> None:
    stored = calibration("Anna Schmidt's OnePlus 9", "anna@example.com", key="c2-anna-schmidt-s-0123456789ab")
    calibrations.publish(stored)
    found = calibrations.get(stored.id)
    assert found is not None
    assert (found.camera, found.platform) == ("OnePlus 9", "other")
    assert found.camera_key == camera_key("OnePlus 9", "other")
