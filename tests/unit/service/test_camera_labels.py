"""Camera keys on the labels that browsers were seen to report."""

import csv
import itertools

import pytest

from calibdb.camera_key import (
    Identity,
    identify,
)
from tests.helpers.data import data_dir, external_data

pytestmark = external_data
LINUX, WINDOWS, MAC = "X11; Linux x86_64", "Windows NT 10.0; Win64; x64", "Macintosh; Intel Mac OS X 10_15_7"
IPHONE = "iPhone; CPU iPhone OS 17_5 like Mac OS X"
Row = dict[str, str]


@pytest.fixture(scope="module")
def rows() -> list[tuple[Row, Identity]]:
    with (data_dir() / "labels.csv").open() as file:
        found = [row for row in csv.DictReader(file) if row["label"]]
    assert len(found) > 90
    return [(row, identify(row["label"], row["platform"] or "unknown")) for row in found]


def resolved(asked: Identity, known: list[Identity]) -> str:
    """The key that answers: USB id and name, or of a name alone the one id that is known under it."""
    ids = {i.key for i in known if i.usb_id and asked.key in i.name_keys}
    return ids.pop() if not asked.usb_id and asked.distinct and len(ids) == 1 else asked.key


def test_no_two_products_share_a_key(rows: list[tuple[Row, Identity]]) -> None:
    known = [identity for _, identity in rows]
    for (a, one), (b, other) in itertools.combinations(rows, 2):
        if a["same_device_group"] != b["same_device_group"]:
            assert one.key != other.key, (a["label"], b["label"])
            assert resolved(one, known) != resolved(other, known), (a["label"], b["label"])


def test_labels_of_one_product_are_found_under_one_key(rows: list[tuple[Row, Identity]]) -> None:
    """Of the pairs of one product that share a USB id or a normalised name, at least nine in ten."""
    known = [identity for _, identity in rows]
    pairs = [
        (one, other)
        for (a, one), (b, other) in itertools.combinations(rows, 2)
        if a["same_device_group"] == b["same_device_group"]
        and ((one.usb_id and one.usb_id == other.usb_id) or one.name == other.name)
    ]
    found = sum(resolved(one, known) == resolved(other, known) for one, other in pairs)
    assert len(pairs) > 100
    assert found / len(pairs) >= 0.9


def test_english_labels_alone_resolve_alike(rows: list[tuple[Row, Identity]]) -> None:
    known = [identity for _, identity in rows]
    english = [(row, i) for row, i in rows if row["platform"].partition("(")[2] in ("", "en)")]
    found = [
        resolved(one, known) == resolved(other, known)
        for (a, one), (b, other) in itertools.combinations(english, 2)
        if a["same_device_group"] == b["same_device_group"] != "virtual"
    ]
    assert len(found) >= 13
    assert sum(found) / len(found) >= 0.9


def test_name_of_two_usb_ids_is_ambiguous(rows: list[tuple[Row, Identity]]) -> None:
    for (_, one), (_, other) in itertools.combinations(rows, 2):
        if one.usb_id and other.usb_id and one.usb_id != other.usb_id and one.name == other.name:
            assert not one.distinct, one.name
