"""Text as it may be stored and shown: without what is not seen."""

from __future__ import annotations

import unicodedata

# Controls, marks of direction and other formats, lone surrogates, private use, and what is not assigned.
_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})


def visible(text: str) -> str:
    """Return `text` in one line, without control characters and others that are not seen."""
    shown = "".join(" " if unicodedata.category(c) in _INVISIBLE else c for c in text)
    return " ".join(shown.split())
