"""Keys of index items and names of objects: how sizes, zooms and ids are written in them."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from calibdb.schema.fields import size_text, zoom_text

WITHDRAWN = ".withdrawn.json"  # what the name of a tombstone ends with

_CONSENSUS_ID = re.compile(r"(c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12})~([0-9]+)x([0-9]+)~([0-9.]+)~([a-z]+)")
_CALIBRATION_ID = re.compile(r"(c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12})-[0-9a-f]{20}")


@dataclass(frozen=True)
class StreamMode:
    """A camera at one image size and zoom: what a consensus is of."""

    camera_key: str
    img_size: tuple[int, int]
    zoom: float

    @property
    def pk(self) -> str:
        """Partition of the camera."""
        return camera_pk(self.camera_key)

    @property
    def text(self) -> str:
        """`1280x720#0`, as it is written in every `sk`."""
        return f"{size_text(self.img_size)}#{zoom_text(self.zoom)}"

    @property
    def calibrations(self) -> str:
        """Prefix of the `sk` of its calibrations."""
        return f"CALIBRATION#{self.text}#"


def camera_pk(camera_key: str) -> str:
    """Partition of a camera."""
    return f"CAMERA#{camera_key}"


def consensus_id(camera_key: str, img_size: tuple[int, int], zoom: float, model: str) -> str:
    """Public id of a consensus."""
    return f"{camera_key}~{size_text(img_size)}~{zoom_text(zoom)}~{model}"


def parse_consensus_id(text: str) -> tuple[str, str] | None:
    """Return partition and `sk` of a consensus, None if it is another id."""
    match = _CONSENSUS_ID.fullmatch(text)
    if match is None:
        return None
    return camera_pk(match[1]), f"CONSENSUS#{match[2]}x{match[3]}#{match[4]}#{match[5]}"


def calibration_object(calibration_id: str) -> str | None:
    """Object's name of a calibration, None if it is another id."""
    match = _CALIBRATION_ID.fullmatch(calibration_id)
    return f"calibrations/{match[1]}/{calibration_id}.json" if match else None


def parse_calibration_object(name: str) -> tuple[str, str] | None:
    """Return camera key and id of a calibration, None if the name is not of one."""
    folder, _, file = name.removeprefix("calibrations/").partition("/")
    calibration_id = file.removesuffix(".json")
    return (folder, calibration_id) if calibration_object(calibration_id) == name else None


def tombstone_object(calibration_id: str) -> str | None:
    """Object's name of the tombstone of a withdrawn calibration, None if it is another id."""
    name = calibration_object(calibration_id)
    return name and name.removesuffix(".json") + WITHDRAWN


def with_tombstones(names: Iterable[str]) -> Iterator[tuple[str, str, bool]]:
    """Yield the last name that belongs to a document, its own name, and whether it was withdrawn.

    A tombstone sorts directly after what it is of.
    """
    document = ""
    for name in names:
        if not name.endswith(WITHDRAWN):
            if document:
                yield document, document, False
            document = name
        elif name == document.removesuffix(".json") + WITHDRAWN:
            yield name, document, True
            document = ""
    if document:
        yield document, document, False


def vote_object(camera_key: str, vote_id: str) -> str:
    """Object's name of a vote."""
    return f"votes/{camera_key}/{vote_id}.json"
