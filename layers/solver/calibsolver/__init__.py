"""Camera calibration from views of a ChArUco board: pure geometry, no clock, no network, no storage."""

from . import capture, consensus, guidance, models, overlay
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
    "capture",
    "consensus",
    "fit",
    "guidance",
    "models",
    "overlay",
]
