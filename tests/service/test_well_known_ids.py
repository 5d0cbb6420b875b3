"""Well-known USB ids of a name."""

from collections.abc import Iterable
from dataclasses import replace

import pytest

from calibdb.camera_key import camera_key, identify
from calibdb.lookup import well_known_ids
from calibdb.settings import Thresholds
from calibdb.store import Store
from calibdb.store.cameras import IdSupport, rivals
from tests.helpers.service.known import LINUX, calibration, consensus, fit
from tests.helpers.service.published import put
from tests.helpers.service.stores import with_methods

RULES = Thresholds(min_contributors=3, contributor_period=0)


def refresh(store: Store, label: str) -> None:
    well_known_ids.refresh_well_known(store, camera_key(label, LINUX), RULES)


def well_known(store: Store, label: str) -> bool:
    identity = identify(label, LINUX)
    (mark,) = {identity.key in store.cameras.known(name).well_known for name in identity.name_keys}
    return mark


def test_overtaken_refresh_reads_again(store: Store) -> None:
    """One size's computation has read everything; before it writes, another size's comes and goes."""
    label = "Overtaken X9 (1111:0030)"
    small = fit((640, 360), 475.0)
    store.calibrations.publish(calibration(label))
    store.calibrations.publish(calibration(label, number=1, of=small))
    stored = consensus(small, camera=label)
    put(store, stored)
    overtaken = []

    def slow(camera: str, names: Iterable[str], support: IdSupport | None) -> bool:
        if not overtaken:
            overtaken.append(support is not None)
            assert store.consensuses.drop(stored)
            refresh(store, label)
        return store.cameras.set_id_support(camera, names, support)

    slowed = replace(store, cameras=with_methods(store.cameras, set_id_support=slow))
    refresh(slowed, label)
    assert overtaken == [True], "it had seen what was there before"
    assert not well_known(store, label)


def test_id_is_well_known_by_one_reliable_size(store: Store) -> None:
    """The smaller size has a reliable consensus, and of its calibrations none counts any more."""
    label = "Small first X9 (1111:0031)"
    small = fit((640, 360), 475.0)
    store.calibrations.publish(calibration(label, of=small, resize_mode="crop-and-scale"))
    store.calibrations.publish(calibration(label, number=1))
    put(store, consensus(small, camera=label), consensus(camera=label, reason="too_few"))
    refresh(store, label)
    assert well_known(store, label)


def test_id_whose_calibrations_disagree_is_not_well_known(store: Store) -> None:
    """Three contributors, and no two of them agree: whoever invents an id needs more than addresses."""
    label = "Invented X9 (dead:0032)"
    for number in range(3):
        store.calibrations.publish(calibration(label, number=number))
    alone = consensus(camera=label, reason="too_few", calibrations=1)
    put(store, alone.model_copy(update={"total": 3}))
    refresh(store, label)
    assert not well_known(store, label)
    assert store.consensuses.drop(alone)
    put(store, consensus(camera=label, reason="too_few", calibrations=3))
    refresh(store, label)
    assert well_known(store, label), "three that agree are some evidence"


@pytest.mark.parametrize(
    ("leader", "rival", "both"),
    [
        (IdSupport(True, 5), IdSupport(False, 4), False),
        (IdSupport(True, 20), IdSupport(True, 3), False),
        (IdSupport(True, 9), IdSupport(True, 3), True),
        (IdSupport(False, 3), IdSupport(False, 3), True),
    ],
)
def test_rival_needs_reliability_and_a_third_of_the_contributors(
    leader: IdSupport, rival: IdSupport, both: bool
) -> None:
    assert rivals({"a": leader, "b": rival}) == (("a", "b") if both else ("a",))
    assert rivals({}) == ()
