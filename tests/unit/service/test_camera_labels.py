"""Camera keys on the labels that browsers were seen to report."""

import itertools

import pytest

from calibdb.camera_key import Identity, identify
from tests.helpers.service import labels
from tests.helpers.service.labels import LabelRow

Rows = list[tuple[LabelRow, Identity]]


@pytest.fixture(scope="module", params=labels.SOURCES)
def rows(request: pytest.FixtureRequest) -> Rows:
    found = labels.rows(request.param)
    assert len(found) > 80
    return [(row, identify(row.label, row.system or "unknown")) for row in found]


def resolved(asked: Identity, known: list[Identity]) -> str:
    """The key that answers: USB id and name, or of a name alone the one id that is known under it."""
    ids = {i.key for i in known if i.usb_id and asked.key in i.name_keys}
    return ids.pop() if not asked.usb_id and asked.distinct and len(ids) == 1 else asked.key


def test_no_two_products_share_a_key(rows: Rows) -> None:
    known = [identity for _, identity in rows]
    for (a, one), (b, other) in itertools.combinations(rows, 2):
        if a.product != b.product:
            assert one.key != other.key, (a.label, b.label)
            assert resolved(one, known) != resolved(other, known), (a.label, b.label)


def test_labels_of_one_product_are_found_under_one_key(rows: Rows) -> None:
    """At least nine in ten pairs that share a USB id or a normalised name, and nine in ten English ones."""
    known = [identity for _, identity in rows]
    same = [pair for pair in itertools.combinations(rows, 2) if pair[0][0].product == pair[1][0].product]
    sharing = [
        (one, other)
        for (_, one), (_, other) in same
        if (one.usb_id and one.usb_id == other.usb_id) or one.name == other.name
    ]
    english = [
        (one, other)
        for (a, one), (b, other) in same
        if a.product != "virtual" and {row.system.partition("(")[2] for row in (a, b)} <= {"", "en)"}
    ]
    for pairs, least in ((sharing, 101), (english, 13)):
        found = [resolved(one, known) == resolved(other, known) for one, other in pairs]
        assert len(found) >= least
        assert sum(found) / len(found) >= 0.9


def test_name_of_two_usb_ids_is_ambiguous(rows: Rows) -> None:
    for (_, one), (_, other) in itertools.combinations(rows, 2):
        if one.usb_id and other.usb_id and one.usb_id != other.usb_id and one.name == other.name:
            assert not one.distinct, one.name
