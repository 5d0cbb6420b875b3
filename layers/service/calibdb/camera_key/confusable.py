"""Confusable letters: Cyrillic and Greek ones that look like Latin ones (Unicode TR 39).

A webcam's name is Latin letters and digits. One of these letters in such a name makes a label that looks
the same and is another.
"""

from __future__ import annotations

import re

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
