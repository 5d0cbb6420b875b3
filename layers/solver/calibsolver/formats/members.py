"""Members of parsed files, whatever the spelling of their names: `Camera_Matrix`, `cameraMatrix`."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from . import text
from .spellings import SHAPE, SIDES, SIZE

MAX_MEMBERS = 10_000
"""Of one mapping that is looked at."""


def normalise(name: object) -> str:
    """Write a member's name in lower case, only letters and digits."""
    return re.sub(r"[^a-z0-9]+", "", str(name)[:200].lower())


class Members:
    """A mapping looked up by normalised names; of two that are alike, the first counts."""

    def __init__(self, data: Mapping[Any, Any]) -> None:
        self._found: dict[str, tuple[str, Any]] = {}
        for key, value in list(data.items())[:MAX_MEMBERS]:
            self._found.setdefault(normalise(key), (str(key), value))

    def __contains__(self, name: str) -> bool:
        """True if the member exists and is not empty."""
        return self.get(name) is not None

    def get(self, *names: str) -> Any:
        """Return the first of `names` that is there and not empty (null, ``""``, ``[]``); else None."""
        for name in names:
            value = self._found.get(name, ("", None))[1]
            if value is not None and value not in ("", [], {}):
                return value
        return None

    def spelling(self, name: str) -> str:
        """Return the name as the file writes it."""
        return self._found.get(name, (name, None))[0]

    def items(self) -> list[tuple[str, Any]]:
        """Return normalised names and values, in the file's order."""
        return [(name, value) for name, (_, value) in self._found.items()]


def image_size(members: Members, index: int = 0) -> tuple[int, int] | None:
    """Return width and height that a mapping states under any of their names; None if it does not.

    `index` is the camera's place in a list: some files have a list of sizes next to it.
    Raises CalibrationError ``malformed`` for a size that is none.
    """
    for wide, high in SIDES:
        if wide in members and high in members:
            spelt = (members.spelling(wide), members.spelling(high))
            return text.count(members.get(wide), spelt[0]), text.count(members.get(high), spelt[1])
    for name in (*SIZE, *SHAPE):
        value = members.get(name)
        if value is None:
            continue
        size = _pair(value, members.spelling(name), index)
        if size:
            return (size[1], size[0]) if name in SHAPE else size
    return None


def _pair(value: Any, name: str, index: int) -> tuple[int, int] | None:
    if isinstance(value, Mapping):
        if "data" in value:
            return _pair(value["data"], name, index)
        inner = Members(value)
        for wide, high in (*SIDES, ("x", "y")):
            if wide in inner and high in inner:
                spelt = (f"{name}.{inner.spelling(wide)}", f"{name}.{inner.spelling(high)}")
                return text.count(inner.get(wide), spelt[0]), text.count(inner.get(high), spelt[1])
        return None
    if isinstance(value, str):
        parts = (
            re.findall(r"\d+(?:\.0*)?", value) if re.fullmatch(r"[\s\d.,xX*×;()\[\]]{3,60}", value) else []
        )
        return (
            (text.count(float(parts[0]), name), text.count(float(parts[1]), name))
            if len(parts) == 2
            else None
        )
    if isinstance(value, Sequence) and value:
        if isinstance(value[0], Sequence | Mapping) and not isinstance(value[0], str) and len(value) > index:
            nested = value[index]
            return _pair(nested, name, 0)
        if len(value) in (2, 3):
            return text.count(value[0], name), text.count(value[1], name)
    return None
