"""Table of USB vendors, made of the USB ID Repository: `python -m infra.web_build.usb_vendors usb.ids`.

Debian's package `usb.ids` has the file as /var/lib/usbutils/usb.ids. Its licence is the GPL-2 or later,
or the 3-clause BSD licence; the table is distributed under the latter.
"""

import re
import sys
from pathlib import Path

TABLE = Path(__file__).parents[2] / "layers" / "service" / "calibdb" / "camera_key" / "usb_vendors.txt"
_VENDOR_LINE = re.compile(
    r"([0-9a-f]{4})  (\S.*)"
)  # devices and interfaces are indented, classes begin with "C "
_VERSION_LINE = re.compile(r"# Version: (\S+)")
_HEAD = """\
# USB vendors: id and name, from the USB ID Repository, version {version}, http://www.linux-usb.org/usb-ids.html
# Copyright (C) Stephen J. Gowdy. Licence: 3-clause BSD (or GPL-2 or later); see NOTICE.
"""


def table(text: str) -> str:
    """Return the table for a `usb.ids` file; raises ValueError if that names no version or no vendor."""
    version = _VERSION_LINE.search(text)
    vendors = filter(None, (_VENDOR_LINE.fullmatch(line.rstrip()) for line in text.splitlines()))
    lines = [f"{vendor_id} {name}\n" for vendor_id, name in sorted(match.groups() for match in vendors)]
    if version is None or not lines:
        raise ValueError("not a usb.ids file: it has no version, or no vendors")
    return _HEAD.format(version=version[1]) + "".join(lines)


if __name__ == "__main__":
    TABLE.write_text(table(Path(sys.argv[1]).read_text(encoding="utf-8")), encoding="utf-8")
