"""USB vendors by their ids. `infra.web_build.usb_vendors` makes the table of the USB ID Repository."""

import functools
from pathlib import Path

from calibdb.camera_key.names import words

_TABLE = Path(__file__).with_name("usb_vendors.txt")
_MAX_WORDS = 4  # of a vendor's name, that cameras are found by
# Words of hundreds of companies' names, which are not searched.
_LEGAL_FORMS = """
    a ag and co corp corporation company gmbh inc incorporated int intl international limited llc ltd of oy
    plc pte pty sa srl the electronics electronic technologies technology tech industrial
"""
_UNSEARCHED = frozenset(_LEGAL_FORMS.split())


@functools.cache
def _table() -> dict[str, str]:
    """Read the table id -> name, at its first use."""
    lines = _TABLE.read_text(encoding="utf-8").splitlines()
    return {line[:4]: line[5:] for line in lines if not line.startswith("#")}


def vendor_of(usb_id: str | None) -> str | None:
    """Vendor's name of a USB id such as `046d:082d`, None if the table has none."""
    return _table().get(usb_id.partition(":")[0]) if usb_id else None


def vendor_words(usb_id: str | None) -> list[str]:
    """Words (lower case) of the vendor's name by which its cameras are searched."""
    vendor = words((vendor_of(usb_id) or "").casefold())
    return [word for word in dict.fromkeys(vendor) if len(word) > 1 and word not in _UNSEARCHED][:_MAX_WORDS]
