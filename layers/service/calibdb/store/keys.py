"""How sizes, zooms and ids are written in names: the one place that knows."""

from __future__ import annotations

import re

_CONSENSUS_ID = re.compile(r"(c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12})~([0-9]+)x([0-9]+)~([0-9.]+)~([a-z]+)")
_CALIBRATION_ID = re.compile(r"(c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12})-[0-9a-f]{20}")


def size_text(img_size: tuple[int, int]) -> str:
    """Return `1280x720`."""
    return f"{img_size[0]}x{img_size[1]}"


def zoom_text(zoom: float) -> str:
    """Return the shortest writing to six decimals: `0`, `1.5`."""
    return f"{zoom:.6f}".rstrip("0").rstrip(".")


def camera_pk(camera_key: str) -> str:
    """Return the partition of a camera."""
    return f"CAMERA#{camera_key}"


def calibrations_prefix(img_size: tuple[int, int], zoom: float) -> str:
    """Return what the `sk` of every calibration at this size and zoom begins with."""
    return f"CALIBRATION#{size_text(img_size)}#{zoom_text(zoom)}#"


def consensus_sk(img_size: tuple[int, int], zoom: float, model: str) -> str:
    """Return the `sk` of a consensus."""
    return f"CONSENSUS#{size_text(img_size)}#{zoom_text(zoom)}#{model}"


def consensus_id(camera_key: str, img_size: tuple[int, int], zoom: float, model: str) -> str:
    """Return the id under which a consensus can be asked for."""
    return f"{camera_key}~{size_text(img_size)}~{zoom_text(zoom)}~{model}"


def parse_consensus_id(text: str) -> tuple[str, str] | None:
    """Return partition and `sk` of the consensus with this id, None when it is no such id."""
    match = _CONSENSUS_ID.fullmatch(text)
    if match is None:
        return None
    return camera_pk(match[1]), f"CONSENSUS#{match[2]}x{match[3]}#{match[4]}#{match[5]}"


def calibration_object(calibration_id: str) -> str | None:
    """Return the object's name of the calibration with this id, None when it is no such id."""
    match = _CALIBRATION_ID.fullmatch(calibration_id)
    return f"calibrations/{match[1]}/{calibration_id}.json" if match else None
