"""Camera calibration from views of a ChArUco board: pure geometry, no clock, no network, no storage."""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from .board import Board
from .camera import Camera
from .errors import CalibrationError
from .fitting.calibration import Calibration
from .fitting.fit import fit
from .fitting.uncertainty import Uncertainty
from .view import View

if TYPE_CHECKING:
    from . import guidance, models
    from .capture import rules
    from .consensus import agreement, pooling
    from .fitting import resection
    from .guidance import overlay
    from .quality import assessment, cross_validation, model_selection, report

__version__ = "0.1.0"

__all__ = [
    "Board",
    "Calibration",
    "CalibrationError",
    "Camera",
    "Uncertainty",
    "View",
    "agreement",
    "capture",
    "choice",
    "consensus",
    "fit",
    "guidance",
    "heldout",
    "models",
    "overlay",
    "report",
    "score",
    "verdict",
]


def __getattr__(name: str) -> ModuleType:
    """Import a module when it is first asked for: a function that starts waits for no other's."""
    if name in __all__:
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
