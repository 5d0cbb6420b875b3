"""Camera keys on the labels that browsers were seen to report."""

import itertools
from collections.abc import Callable

import pytest

from calibdb.camera_key import Identity, identify
from tests.helpers.service import labels
from tests.helpers.service.labels import LabelRow

Row = tuple[LabelRow, Identity]
Rows = list[Row]


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


def alike(rows: Rows, is_pair: Callable[[Row, Row], bool]) -> list[bool]:
    """True for each such pair of one product whose labels are found under one key."""
    known = [identity for _, identity in rows]
    return [
        resolved(one[1], known) == resolved(other[1], known)
        for one, other in itertools.combinations(rows, 2)
        if one[0].product == other[0].product and is_pair(one, other)
    ]


def test_labels_of_one_product_are_found_under_one_key(rows: Rows) -> None:
    """Of the pairs of one product that share a USB id or a normalised name, at least nine in ten."""

    def share(one: Row, other: Row) -> bool:
        a, b = one[1], other[1]
        return bool(a.usb_id and a.usb_id == b.usb_id) or a.name == b.name

    found = alike(rows, share)
    assert len(found) > 100
    assert sum(found) / len(found) >= 0.9


def test_english_labels_alone_resolve_alike(rows: Rows) -> None:
    english = [row for row in rows if row[0].system.partition("(")[2] in ("", "en)")]
    found = alike(english, lambda one, _: one[0].product != "virtual")
    assert len(found) >= 13
    assert sum(found) / len(found) >= 0.9


def test_name_of_two_usb_ids_is_ambiguous(rows: Rows) -> None:
    for (_, one), (_, other) in itertools.combinations(rows, 2):
        if one.usb_id and other.usb_id and one.usb_id != other.usb_id and one.name == other.name:
            assert not one.distinct, one.name
