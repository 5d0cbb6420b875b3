"""Camera keys on the labels that browsers were seen to report."""

import itertools

import pytest

from calibdb.camera_key import Identity, identify
from tests.helpers.service import labels
from tests.helpers.service.labels import LabelRow


@pytest.fixture(scope="module", params=labels.SOURCES)
def rows(request: pytest.FixtureRequest) -> list[tuple[LabelRow, Identity]]:
    found = labels.rows(request.param)
    assert len(found) > 80
    return [(row, identify(row.label, row.system or "unknown")) for row in found]


def resolved(asked: Identity, known: list[Identity]) -> str:
    """The key that answers: USB id and name, or of a name alone the one id that is known under it."""
    ids = {i.key for i in known if i.usb_id and asked.key in i.name_keys}
    return ids.pop() if not asked.usb_id and asked.distinct and len(ids) == 1 else asked.key


def test_no_two_products_share_a_key(rows: list[tuple[LabelRow, Identity]]) -> None:
    known = [identity for _, identity in rows]
    for (a, one), (b, other) in itertools.combinations(rows, 2):
        if a.product != b.product:
            assert one.key != other.key, (a.label, b.label)
            assert resolved(one, known) != resolved(other, known), (a.label, b.label)


def test_labels_of_one_product_are_found_under_one_key(rows: list[tuple[LabelRow, Identity]]) -> None:
    """Of the pairs of one product that share a USB id or a normalised name, at least nine in ten."""
    known = [identity for _, identity in rows]
    pairs = [
        (one, other)
        for (a, one), (b, other) in itertools.combinations(rows, 2)
        if a.product == b.product and ((one.usb_id and one.usb_id == other.usb_id) or one.name == other.name)
    ]
    found = sum(resolved(one, known) == resolved(other, known) for one, other in pairs)
    assert len(pairs) > 100
    assert found / len(pairs) >= 0.9


def test_english_labels_alone_resolve_alike(rows: list[tuple[LabelRow, Identity]]) -> None:
    known = [identity for _, identity in rows]
    english = [(row, i) for row, i in rows if row.system.partition("(")[2] in ("", "en)")]
    found = [
        resolved(one, known) == resolved(other, known)
        for (a, one), (b, other) in itertools.combinations(english, 2)
        if a.product == b.product != "virtual"
    ]
    assert len(found) >= 13
    assert sum(found) / len(found) >= 0.9


def test_name_of_two_usb_ids_is_ambiguous(rows: list[tuple[LabelRow, Identity]]) -> None:
    for (_, one), (_, other) in itertools.combinations(rows, 2):
        if one.usb_id and other.usb_id and one.usb_id != other.usb_id and one.name == other.name:
            assert not one.distinct, one.name
