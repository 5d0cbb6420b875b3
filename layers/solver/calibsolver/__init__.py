"""Camera calibration from views of a ChArUco board: pure geometry, no clock, no network, no storage."""

from . import (
    agreement,
    capture,
    choice,
    consensus,
    guidance,
    heldout,
    models,
    overlay,
    report,
    score,
    verdict,
)
from .board import Board
from .calibration import Calibration
from .camera import Camera
from .errors import CalibrationError
from .fit import fit
from .uncertainty import Uncertainty
from .view import View

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
