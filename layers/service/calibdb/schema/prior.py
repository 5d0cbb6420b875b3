"""A calibration without keypoints, from another source: only a first guess for a capture."""

from __future__ import annotations

from typing import Literal

from calibdb.schema.calibration import FitRecord
from calibdb.schema.fields import Open


class PriorDocument(Open):
    """`priors/<camera key>/<w>x<h>~<zoom>~<model>.json`. No lookup ever answers with it."""

    layout: Literal[1] = 1
    camera_key: str
    camera: str
    platform: str
    zoom: float
    fit: FitRecord
    source: str
    measured: int  # how many calibrations of that source it stands for
