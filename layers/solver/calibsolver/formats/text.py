"""Numbers and files as text, in full precision."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import CalibrationError

MAX_NUMBER = 1e12
"""Beyond which no number is a camera's."""


def number(value: float) -> str:
    """Write a float so that reading it gives the same again, and so that YAML 1.1 takes it for a float."""
    text = repr(float(value))
    return text if "." in text or "e" not in text else text.replace("e", ".0e")


def numbers(values: Iterable[float]) -> str:
    """Write floats as the inside of a list."""
    return ", ".join(number(value) for value in values)


def lines(*parts: str | Iterable[str]) -> bytes:
    """Join lines to the content of a file."""
    flat: list[str] = []
    for part in parts:
        flat.extend([part] if isinstance(part, str) else part)
    return ("\n".join(flat) + "\n").encode()


def dump(value: Mapping[str, Any], warning: str | None = None) -> bytes:
    """Write a JSON object, the warning as its member ``warning``."""
    if warning:
        value = {**value, "warning": warning}
    return (json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def quote(text: str) -> str:
    """Write a string in double quotes, as JSON and YAML both read it."""
    return json.dumps("".join(c if c.isprintable() else " " for c in text))


def refuse(what: str) -> CalibrationError:
    """Return the error of a file that does not hold what it should."""
    return CalibrationError("malformed", what)


def member(data: object, *path: str) -> Any:
    """Look up `path` in parsed data; CalibrationError ``malformed`` names the missing part."""
    here: Any = data
    for i, key in enumerate(path):
        if not has_member(here, key):
            raise refuse(f"the file has no {'.'.join(path[: i + 1])}")
        here = here[key]
    return here


def has_member(data: object, key: str) -> bool:
    """True if parsed data is an object with such a member."""
    return isinstance(data, Mapping) and key in data


_NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][-+]?\d+)?f?", re.ASCII)
MAX_NUMBERS_TEXT = 100_000
MAX_NUMBER_LENGTH = 100
"""Characters of one number: a float in full precision has 25."""


def number_list(value: str) -> list[float] | None:
    """Return the numbers of a text of only numbers ("640, 480", "[1.5 2; 3 4]"); None for any other."""
    if len(value) > MAX_NUMBERS_TEXT or not any(c.isdigit() for c in value[:100]):
        return None
    words = re.split(r"[\s,;\[\](){}]+", value.strip(" \t\r\n,;[](){}"))
    if not all(len(word) <= MAX_NUMBER_LENGTH and _NUMBER.fullmatch(word) for word in words):
        return None
    return [float(word.rstrip("f").replace("d", "e").replace("D", "e")) for word in words]


def floats(value: object, name: str, min_count: int = 0, max_count: int = 1_000_000) -> Array:
    """Return nested lists of numbers, or of texts of numbers, as one flat array; else raise ``malformed``.

    NaN and numbers that no camera has are refused too.
    """
    flat: list[float] = []

    def take(item: object, depth: int) -> None:
        if depth > 4 or len(flat) > max_count:
            raise refuse(f"{name} has more in it than it should")
        if isinstance(item, list | tuple):
            for part in item:
                take(part, depth + 1)
        elif isinstance(item, str) and (parts := number_list(item)) is not None:
            take(parts, depth + 1)
        elif isinstance(item, bool) or not isinstance(item, int | float):
            raise refuse(f"{name} must be numbers, not {type(item).__name__}")
        elif not -MAX_NUMBER < item < MAX_NUMBER:  # NaN is neither
            what = "NaN" if isinstance(item, float) and math.isnan(item) else "a number"
            raise refuse(f"{name} holds {what}, which is none of a camera's")
        else:
            flat.append(float(item))

    take(value, 0)
    if not min_count <= len(flat) <= max_count:
        raise refuse(f"{name} must be {min_count} to {max_count} numbers, not {len(flat)}")
    return np.array(flat)


def scalar(value: object, name: str) -> float:
    """Return one number; ``malformed`` for anything else."""
    return float(floats(value, name, 1, 1)[0])


def width_height(sides: Iterable[object], names: Sequence[str] = ("width", "height")) -> tuple[int, int]:
    """Return the size of an image; `names` are those of its sides in errors."""
    width, height = (count(side, name) for side, name in zip(sides, names, strict=True))
    return width, height


def count(value: object, name: str) -> int:
    """Return a whole number of 1 to 65,536."""
    size = scalar(value, name)
    if not (size == int(size) and 1 <= size <= 65_536):
        raise refuse(f"{name} must be a whole number of 1 to 65536")
    return int(size)
