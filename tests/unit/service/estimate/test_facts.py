"""Table of facts: every row can be read, names source and licence; no share-alike collection."""

import re

from calibdb.camera_key.names import words
from calibdb.estimate.angles import horizontal_angle
from calibdb.estimate.crops import SLOPES
from calibdb.estimate.facts import FACT_COLUMNS, all_facts, rows

KINDS = set(SLOPES) - {"webcam", "virtual", "phone_ultrawide", "phone_tele"}
SHARE_ALIKE = re.compile(r"BY-SA|share.?alike|ODbL", re.IGNORECASE)
REFUSED_SOURCES = re.compile(r"arcore-for-all|lensfun|mapillary\.com", re.IGNORECASE)


def test_every_row_can_be_read() -> None:
    table = rows()
    assert len(table) > 500
    assert {tuple(row) for row in table} == {FACT_COLUMNS}
    for row, fact in zip(table, all_facts(), strict=True):
        assert fact.kind in KINDS, row
        assert fact.size[0] >= fact.size[1] > 0, row
        assert 15 < horizontal_angle(fact.log_tan) < 170, row
        assert 0.001 < fact.sigma < (0.7 if row["words"] else 2.0), row  # without words: a sample of its kind
        assert fact.n >= 1, row
        assert row["what"] in {"calibration", "specification", "reported", "measurement"}, row
        assert row["camera"] in {"", "wide", "ultrawide", "tele", "front"}, row
        assert len(fact.lens) in (0, 4), row


def test_every_row_has_a_source_and_a_licence() -> None:
    for row in rows():
        assert re.fullmatch(r"https?://[^/ ]+(/[^ ]*)?", row["url"]), row
        assert row["title"], row
        assert row["licence"], row
        assert not SHARE_ALIKE.search(row["licence"]), row
        assert not REFUSED_SOURCES.search(row["url"]), row


def test_identifiers_are_as_a_lookup_has_them() -> None:
    for row in rows():
        for usb_id in filter(None, row["usb"].split(";")):
            assert re.fullmatch(r"[0-9a-f]{4}:[0-9a-f]{4}", usb_id), row
        assert row["devices"] == row["devices"].casefold(), row
        for text in filter(None, row["words"].split(";")):
            assert words(text), row
            assert text == text.casefold(), row


def test_rows_are_unique() -> None:
    keys = [tuple(row.values()) for row in rows()]
    assert len(set(keys)) == len(keys)
