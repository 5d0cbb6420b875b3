"""The OCamCalib toolbox's calib_results.txt: a polynomial of the distance from the centre."""

import numpy as np

from . import text
from .base import ImportedFile
from .foreign_models import closest_camera, scaramuzza


def is_results(content: str) -> bool:
    """True if a text is such a file."""
    return "#polynomial coefficients for the DIRECT mapping" in content


def read(content: str) -> ImportedFile:
    """Read the file: the closest camera; CalibrationError ``malformed``.

    Pixels are counted from 0, rows before columns, and the optical axis is -z.
    """
    rows = [
        numbers
        for line in content.splitlines()[:200]
        if line.strip() and not line.lstrip().startswith("#")
        if (numbers := text.number_list(line)) is not None
    ]
    if len(rows) < 5 or len(rows[2]) != 2 or len(rows[3]) != 3 or len(rows[4]) != 2:
        raise text.refuse("the file has not the five rows of calib_results.txt")
    count = int(rows[0][0])
    polynomial = text.floats(rows[0][1:], "polynomial", 1, 30)
    if len(polynomial) != count or not polynomial[0]:
        raise text.refuse("the polynomial has not as many coefficients as the file says")
    height, width = (text.count(value, "image size") for value in rows[4])
    centre, affine = (rows[2][0], rows[2][1]), (rows[3][0], rows[3][1], rows[3][2])
    if abs(affine[0] - affine[1] * affine[2]) < 1e-6:
        raise text.refuse("the affine parameters are singular")
    if polynomial[0] > 0:  # written by programs that look along +z
        polynomial = -polynomial
    return closest_camera(scaramuzza(np.array(polynomial), centre, affine), (width, height))
