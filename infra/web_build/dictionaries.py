"""Write the ArUco marker bits with which the web client draws boards.

    python -m infra.web_build.dictionaries

OpenCV's dictionaries of one marker size are prefixes of the largest, so four tables contain all of them; the
original one and AprilTag's families have one each. Bits are packed row by row, marker after marker, most
significant bit first, 1 = white, without the black border.
"""

import base64
from pathlib import Path

import cv2
import numpy as np

DICTIONARIES_PATH = Path(__file__).parents[2] / "web" / "vendor" / "dictionaries.js"
TABLES = {
    "4X4": ("DICT_4X4_1000", 4),
    "5X5": ("DICT_5X5_1000", 5),
    "6X6": ("DICT_6X6_1000", 6),
    "7X7": ("DICT_7X7_1000", 7),
    "ARUCO_ORIGINAL": ("DICT_ARUCO_ORIGINAL", 5),
    "APRILTAG_16h5": ("DICT_APRILTAG_16h5", 4),
    "APRILTAG_25h9": ("DICT_APRILTAG_25h9", 5),
    "APRILTAG_36h10": ("DICT_APRILTAG_36h10", 6),
    "APRILTAG_36h11": ("DICT_APRILTAG_36h11", 6),
}


def _bits(name: str) -> np.ndarray:
    """Return the inner bits of every marker of a predefined dictionary, (markers, side, side) of 0 and 1."""
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    side = dictionary.markerSize
    return np.stack(
        [
            cv2.aruco.Dictionary.getBitsFromByteList(row[None], side)
            for row in np.asarray(dictionary.bytesList, dtype=np.uint8)
        ]
    )


def text() -> str:
    """Return the JavaScript module."""
    lines = ["// Made by infra/web_build/dictionaries.py from OpenCV's ArUco dictionaries."]
    lines.append("/** @type {Record<string, {side: number, count: number, bits: string}>} */")
    lines.append("export const TABLES = {")
    for key, (name, side) in TABLES.items():
        table = _bits(name)
        for count in (50, 100, 250):
            if key[0].isdigit() and not np.array_equal(_bits(f"DICT_{key}_{count}"), table[:count]):
                raise ValueError(f"DICT_{key}_{count} is not a prefix of {name}")
        packed = base64.b64encode(np.packbits(table.astype(np.uint8).ravel()).tobytes()).decode()
        lines.append(f'  "{key}": {{ side: {side}, count: {len(table)}, bits: "{packed}" }},')
    lines.append("};")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    DICTIONARIES_PATH.write_text(text())
