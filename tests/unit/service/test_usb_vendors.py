"""The table of USB vendors, and the words that cameras are found by."""

import pytest

from calibdb.camera_key.usb_vendors import vendor_of, vendor_words
from infra.web_build.usb_vendors import TABLE, table

EXCERPT = """\
# Version: 2020.01.02
046d  Logitech, Inc.
\t082d  HD Pro Webcam C920
\t\t01  an interface
045e  Microsoft Corp.
C 00  (Defined at Interface level)
"""


def test_vendors_of_webcams_are_known() -> None:
    found = {usb_id: vendor_of(usb_id) for usb_id in ("046d:082d", "04f2:b6d9", "045e:0779")}
    assert found == {
        "046d:082d": "Logitech, Inc.",
        "04f2:b6d9": "Chicony Electronics Co., Ltd",
        "045e:0779": "Microsoft Corp.",
    }
    assert vendor_of("0000:0001") is None
    assert vendor_of(None) is None


def test_words_of_vendors_are_names_and_no_legal_forms() -> None:
    assert vendor_words("046d:082d") == ["logitech"]
    assert vendor_words("04f2:b6d9") == ["chicony"]
    assert vendor_words(None) == []


def test_table_is_made_of_the_lines_of_vendors() -> None:
    lines = table(EXCERPT).splitlines()
    assert [line for line in lines if not line.startswith("#")] == [
        "045e Microsoft Corp.",
        "046d Logitech, Inc.",
    ]
    assert "version 2020.01.02" in lines[0]
    with pytest.raises(ValueError, match="no version, or no vendors"):
        table("<html>")


def test_stored_table_has_all_vendors_once_and_in_order() -> None:
    ids = [line[:4] for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert ids == sorted(set(ids))
    assert len(ids) > 3000
