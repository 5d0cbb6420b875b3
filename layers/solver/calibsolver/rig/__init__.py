"""Rigs: cameras that do not move against each other, fitted together to boards that several of them saw."""

from .calibration import RigCalibration, RigUncertainty
from .estimate import estimate
from .fit import fit, held_out_rms
from .guidance import RigTarget, next_moment
from .problem import MAX_ONLINE_POINTS, thin

__all__ = [
    "MAX_ONLINE_POINTS",
    "RigCalibration",
    "RigTarget",
    "RigUncertainty",
    "estimate",
    "fit",
    "held_out_rms",
    "next_moment",
    "thin",
]
