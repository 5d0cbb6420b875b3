"""Rigs: cameras that do not move against each other, fitted together from boards that several of them saw."""

from .calibration import RigCalibration, RigUncertainty
from .fit import fit

__all__ = ["RigCalibration", "RigUncertainty", "fit"]
