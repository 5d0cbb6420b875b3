"""Camera calibration from views of a ChArUco board: pure geometry, no clock, no network, no storage."""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from .board import Board
from .camera import Camera
from .errors import CalibrationError, DeadlineError
from .fitting.calibration import Calibration
from .fitting.fit import fit
from .fitting.uncertainty import Uncertainty
from .locate import BoardPose, locate
from .view import View

if TYPE_CHECKING:
    from . import capture, consensus, fitting, formats, guidance, models, plots, quality, rig

__version__ = "0.1.0"
FIT_VERSION = "0.1.1"
"""Version of the results: a new one makes the service recompute every stored consensus."""

__all__ = [
    "FIT_VERSION",
    "Board",
    "BoardPose",
    "Calibration",
    "CalibrationError",
    "Camera",
    "DeadlineError",
    "Uncertainty",
    "View",
    "capture",
    "consensus",
    "fit",
    "fitting",
    "formats",
    "guidance",
    "locate",
    "models",
    "plots",
    "quality",
    "rig",
]


def __getattr__(name: str) -> ModuleType:
    """Import a package at its first use, so that a function loads only the packages that it needs."""
    if name in __all__:
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
