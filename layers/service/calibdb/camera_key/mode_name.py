"""Name that a person gives to a mode of a camera, such as `stabilisation on`."""

from __future__ import annotations

import re
import unicodedata

from calibdb.camera_key.owner import without_owner, without_path, without_telephone
from calibdb.camera_key.visible import visible

MAX_MODE_NAME = 32
# Letters and digits of any script, and the signs of settings: `4K, 16:9`, `78°`, `Linear + Horizon`.
_ALLOWED = re.compile(r"[^\W_](?:[\w °.,:+×%/-]*[\w°%+])?")
_LONG_NUMBER = re.compile(r"\d{5}")


def public_mode_name(text: str) -> str:
    """Return `text` as it may be stored and shown; empty if it may not.

    Names of persons, addresses and telephone numbers are removed.
    """
    name = unicodedata.normalize("NFC", visible(text))
    while (shorter := without_owner(without_telephone(without_path(name)))) != name:
        name = shorter
    allowed = len(name) <= MAX_MODE_NAME and _ALLOWED.fullmatch(name) and not _LONG_NUMBER.search(name)
    return name if allowed else ""
