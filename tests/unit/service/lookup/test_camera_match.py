"""Match of a lookup: the key under which a camera is found, reads of the index, choice of a consensus."""

from typing import Any

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.lookup import camera_match
from calibdb.lookup.camera_match import choose
from calibdb.schema import ConsensusDocument
from calibdb.schema.fields import StreamKey
from calibdb.store import CameraRecords
from tests.helpers.service.known import C920, LINUX, consensus, fit

SIZE = (1280, 720)


def query(label: str, platform: str = LINUX) -> StreamKey:
    return StreamKey(camera=label, platform=platform, img_size=SIZE)


FIREFOX = query("HD Pro Webcam C920", "Windows NT 10.0; Win64; x64")
NAMED, CHROME = identify(FIREFOX.camera, FIREFOX.platform), identify(C920, LINUX)
OTHER = identify("HD Pro Webcam C920 (046d:0892)", LINUX)


def resolve(
    index: dict[str, CameraRecords], asked: StreamKey = FIREFOX, *, private: bool = False
) -> tuple[str, object, int]:
    keys: list[str] = []

    def read(key: str) -> CameraRecords:
        keys.append(key)
        return index.get(key, CameraRecords([]))

    found = camera_match.resolve(read, asked, private=private)
    assert len(keys) <= 2
    assert keys[0] == camera_key(asked.camera, asked.platform)
    return found.key, found.choice.found, len(keys)


def named(*known: ConsensusDocument, other: ConsensusDocument | None = None) -> dict[str, CameraRecords]:
    """Index of a name, and of the USB id that is known under it."""
    found = CameraRecords([other or consensus()])
    return {NAMED.key: CameraRecords([*known], (CHROME.key,)), CHROME.key: found}


def test_calibrations_of_the_name_come_first() -> None:
    known = consensus(camera="HD Pro Webcam C920")
    assert resolve(named(known)) == (NAMED.key, known, 1)
    few = consensus(camera="HD Pro Webcam C920", reason="too_few", calibrations=2)
    assert resolve(named(few))[0] == CHROME.key


def test_few_calibrations_of_the_name_do_not_outvote_the_usb_id() -> None:
    def of(contributors: int, **made: Any) -> ConsensusDocument:
        stored = consensus(**made)
        said = stored.calibration.model_copy(update={"contributors": contributors})
        return stored.model_copy(update={"calibration": said})

    few = of(3, camera="HD Pro Webcam C920")
    for contributors, wins in ((4, True), (3, False)):
        many = of(contributors)
        index = {
            NAMED.key: CameraRecords([few], (CHROME.key,), well_known=(CHROME.key,)),
            CHROME.key: CameraRecords([many]),
        }
        assert resolve(index) == ((CHROME.key, many, 2) if wins else (NAMED.key, few, 2))
        assert resolve(index, private=True) == (NAMED.key, few, 1)
    elsewhere = {**index, CHROME.key: CameraRecords([of(12, of=fit((640, 360)))])}
    assert resolve(elsewhere) == (NAMED.key, few, 2)
    two = {
        **index,
        NAMED.key: CameraRecords([few], (CHROME.key, OTHER.key), well_known=(CHROME.key, OTHER.key)),
    }
    assert resolve(two) == (NAMED.key, few, 1)


def test_name_with_contradictory_calibrations_finds_nothing() -> None:
    split = consensus(camera="HD Pro Webcam C920", reason="disagree")
    assert resolve(named(split)) == (NAMED.key, None, 1)


def test_uncalibrated_usb_id_finds_its_name() -> None:
    known = consensus(camera="HD Pro Webcam C920")
    assert resolve({CHROME.name_key: CameraRecords([known])}, query(C920)) == (CHROME.name_key, known, 2)
    assert resolve({CHROME.name_key: CameraRecords([known], (OTHER.key,))}, query(C920))[1:] == (known, 2)
    taken = CameraRecords([known], (OTHER.key,), well_known=(OTHER.key,))
    assert resolve({CHROME.name_key: taken}, query(C920)) == (CHROME.key, None, 2)
    index = {
        CHROME.key: CameraRecords([consensus(reason="disagree")]),
        CHROME.name_key: CameraRecords([known]),
    }
    assert resolve(index, query(C920)) == (CHROME.key, None, 1)


def test_generic_name_is_found_on_private_deployments_only() -> None:
    asked, with_id = query("Integrated Camera"), identify("Integrated Camera (04f2:b6d0)", LINUX)
    named = camera_key("Integrated Camera", LINUX)
    index = {named: CameraRecords([], (with_id.key,)), with_id.key: CameraRecords([consensus()])}
    assert resolve(index, asked) == (named, None, 1)
    assert camera_match.unanswerable_reason(asked, private=False) == camera_match.AMBIGUOUS
    assert resolve(index, asked, private=True)[0] == with_id.key
    assert camera_match.unanswerable_reason(asked, private=True) is None


def test_computable_model_is_an_answer() -> None:
    other = consensus(fit(model="rational", distortion=(0.0,) * 8))
    assert resolve(named(other=other))[0] == CHROME.key


def stored(
    size: tuple[int, int], model: str = "rectilinear", reason: str | None = None, total: int = 5
) -> ConsensusDocument:
    return consensus(fit(size, model=model), reason=reason, calibrations=total)


HD, FULL_HD, VGA, SD = (1280, 720), (1920, 1080), (640, 480), (854, 480)


@pytest.mark.parametrize(
    ("sizes", "asked", "answered"),
    [
        ([HD, FULL_HD, VGA], HD, HD),
        ([FULL_HD, VGA], HD, FULL_HD),  # same aspect before closer area
        ([SD, VGA], HD, SD),
        ([VGA], HD, VGA),
        ([VGA, (1600, 1200)], (1024, 768), (1600, 1200)),  # 2.4 times the area, not 1 / 2.6
        ([SD, FULL_HD, (3840, 2160)], (3000, 1687), (3840, 2160)),  # 16:9 to the pixel, and almost
        ([(720, 1280), VGA], HD, VGA),
    ],
)
def test_closest_size(
    sizes: list[tuple[int, int]], asked: tuple[int, int], answered: tuple[int, int]
) -> None:
    known = [stored(size) for size in sizes]
    for order in (known, known[::-1]):
        choice = choose(order, asked, 0.0, "rectilinear")
        assert choice.found.img_size == answered


def test_only_reliable_consensuses_answer() -> None:
    choice = choose([stored(HD, reason="disagree"), stored(VGA)], HD, 0.0, "rectilinear")
    assert choice.found.img_size == VGA
    choice = choose([stored(HD, reason="disagree"), stored(VGA, reason="too_few")], HD, 0.0, "rectilinear")
    assert (choice.found, choice.reason) == (None, "disagree")


def test_missing_model_is_computed_where_another_is_reliable() -> None:
    assert choose([stored(HD)], FULL_HD, 0.0, "fisheye").missing_at == HD
    assert choose([stored(HD, reason="too_few")], HD, 0.0, "fisheye").missing_at is None
    both = [stored(HD), stored(HD, "fisheye", reason="disagree")]
    choice = choose(both, HD, 0.0, "fisheye")
    assert (choice.missing_at, choice.reason) == (None, "disagree")


def test_outdated_model_is_recomputed() -> None:
    known = [stored(HD), stored(HD, "fisheye", reason="too_few", total=4)]
    assert choose(known, HD, 0.0, "fisheye").missing_at == HD
