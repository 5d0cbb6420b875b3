"""Characters of labels: invisible ones are removed, confusable ones become Latin."""

import re
import unicodedata

MAX_TEXT_LENGTH = 4096
# Controls, formats, lone surrogates, private use, unassigned.
_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
# Zero-width formats, and of Default_Ignorable_Code_Point (Unicode, DerivedCoreProperties) the joiners and
# variation selectors.
_ZERO_WIDTH = re.compile(
    "[\u00ad\u034f\u061c\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufe00-\ufe0f\ufeff"
    "\U000e0000-\U000e0fff]"
)
# Letters and symbols that are drawn as nothing: Hangul's fillers, Braille's blank.
_BLANK = frozenset("\u115f\u1160\u2800\u3164\uffa0")


def visible(text: str) -> str:
    """First `MAX_TEXT_LENGTH` characters of `text` in one line, without invisible ones."""
    text = _ZERO_WIDTH.sub("", text[:MAX_TEXT_LENGTH])
    shown = "".join(" " if c in _BLANK or unicodedata.category(c) in _INVISIBLE else c for c in text)
    return " ".join(shown.split())


# Cyrillic and Greek letters that look like Latin ones (Unicode TR 39).
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

    In a text with Latin letters also words of only such letters.
    """
    some_latin = _LATIN.search(text) is not None

    def fold(match: re.Match[str]) -> str:
        word = match[0]
        folded = word.translate(_TO_LATIN)
        mixed = some_latin or any(c.isascii() for c in word)
        return folded if mixed and folded.isascii() else word

    return _WORD_CHARACTERS.sub(fold, text)
