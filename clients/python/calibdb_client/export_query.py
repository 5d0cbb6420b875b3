"""Changes of a picture of which a file is wanted: cut, then resized, then turned, then mirrored."""

from __future__ import annotations

from collections.abc import Sequence

from .errors import UsageError

FORMATS = (
    *("calibdb", "opencv-yaml", "opencv-json", "ros", "kalibr", "colmap", "opensfm", "mrcal", "corners-vnl"),
    *("gyroflow", "lensfun", "dng", "webxr", "gltf", "photonvision", "artoolkit"),
)
"""Formats of the service, as of this version; a newer service may know more."""


def export_query(
    format: str,  # noqa: A002 - the contract's name
    crop: Sequence[int] | None = None,
    resize: Sequence[int] | None = None,
    rotate: int = 0,
    mirror: bool = False,
) -> dict[str, str]:
    """Return the query of an export. Raises UsageError for numbers that describe no picture."""
    query = {"format": format}
    if crop is not None:
        if len(crop) != 4:
            raise UsageError("crop has four numbers: left, top, width, height")
        query["crop"] = ",".join(str(int(each)) for each in crop)
    if resize is not None:
        if len(resize) != 2:
            raise UsageError("resize has two numbers: width, height")
        query["resize"] = "x".join(str(int(each)) for each in resize)
    if rotate not in (0, 90, 180, 270):
        raise UsageError(f"rotate is 0, 90, 180 or 270, not {rotate}")
    if rotate:
        query["rotate"] = str(rotate)
    if mirror:
        query["mirror"] = "1"
    return query
