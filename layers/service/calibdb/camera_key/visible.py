"""Text that may be stored and shown, without invisible characters."""

from __future__ import annotations

import re
import unicodedata

MAX_TEXT_LENGTH = 4096
# Controls, marks of direction and other formats, lone surrogates, private use, and what is not assigned.
_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
# What takes no room, so that a text with it looks like one without: zero-width formats, and of
# Default_Ignorable_Code_Point (Unicode, DerivedCoreProperties) the joiners and variation selectors.
_ZERO_WIDTH = re.compile(
    "[\u00ad\u034f\u061c\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufe00-\ufe0f\ufeff"
    "\U000e0000-\U000e0fff]"
)
# Letters and symbols that are drawn as nothing: Hangul's fillers, Braille's blank.
_BLANK = frozenset("\u115f\u1160\u2800\u3164\uffa0")


def visible(text: str) -> str:
    """Return `text` in one line, without control characters and others that are not seen.

    Characters beyond `MAX_TEXT_LENGTH` are dropped.
    """
    text = _ZERO_WIDTH.sub("", text[:MAX_TEXT_LENGTH])
    shown = "".join(" " if c in _BLANK or unicodedata.category(c) in _INVISIBLE else c for c in text)
    return " ".join(shown.split())
