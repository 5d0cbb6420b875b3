"""Characters of texts that may be stored and shown: invisible ones go, confusable ones become Latin."""

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


# Cyrillic and Greek letters that look like Latin ones (Unicode TR 39). A webcam's name is Latin letters and
# digits. One of these letters in such a name makes a label that looks the same and is another.
_PAIRS = (
    ("АВЕЅІЈКМНОРСТУХӀԌԚԜ", "ABESIJKMHOPCTYXIGQW"),
    ("аеорсухѕіјһԁԛԝӏ", "aeopcyxsijhdqwl"),
    ("ΑΒΕΖΗΙΚΜΝΟΡΤΥΧον", "ABEZHIKMNOPTYXov"),
)
_TO_LATIN = str.maketrans("".join(theirs for theirs, _ in _PAIRS), "".join(latin for _, latin in _PAIRS))
_WORD_CHARACTERS = re.compile(r"\w+")
_LATIN = re.compile(r"[A-Za-z]")


def in_latin(text: str) -> str:
    """Return `text` with confusable letters as Latin ones, in words that otherwise are Latin or digits.

    Words of nothing but such letters are taken for Latin where another word is. Others, as of a label that is
    Cyrillic, stay.
    """
    some_latin = _LATIN.search(text) is not None

    def fold(match: re.Match[str]) -> str:
        word = match[0]
        folded = word.translate(_TO_LATIN)
        mixed = some_latin or any(c.isascii() for c in word)
        return folded if mixed and folded.isascii() else word

    return _WORD_CHARACTERS.sub(fold, text)
