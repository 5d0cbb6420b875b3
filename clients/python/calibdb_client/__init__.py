"""Camera calibrations for programs: the same database that browsers use.

    from calibdb_client import Client
    client = Client("https://calibdb.example", token="cdb_...")
    found = client.lookup(
        "HD Pro Webcam C920 (046d:082d)", platform="X11; Linux x86_64", size=(1280, 720)
    )

Most names are imported when they are first used: the import itself loads neither numpy, nor OpenCV, nor a
network.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .errors import (
    CalibDBError,
    CameraError,
    CaptureError,
    ConflictError,
    CredentialError,
    MissingPackageError,
    NotFoundError,
    ProblemError,
    QuotaError,
    ServiceUnavailableError,
    UsageError,
)
from .files import ExportedFile
from .key import CameraKey

if TYPE_CHECKING:
    from . import offline
    from .aio import AsyncClient
    from .board import Board
    from .calibration import Answer, Calibration, Estimate
    from .camera import Camera, open_camera
    from .capture.operation import CaptureInterruptedError
    from .checks import CheckResult
    from .client import Client
    from .recording import Recording
    from .rig import Rig
    from .session import CaptureResult

__version__ = "0.1.0"

_NAMES = {
    "aio": ("AsyncClient",),
    "board": ("Board",),
    "calibration": ("Answer", "Calibration", "Estimate"),
    "camera": ("Camera", "open_camera"),
    "capture.operation": ("CaptureInterruptedError",),
    "checks": ("CheckResult",),
    "client": ("Client",),
    "recording": ("Recording",),
    "rig": ("Rig",),
    "session": ("CaptureResult",),
}
"""Names by module."""

__all__ = [
    "Answer",
    "AsyncClient",
    "Board",
    "CalibDBError",
    "Calibration",
    "Camera",
    "CameraError",
    "CameraKey",
    "CaptureError",
    "CaptureInterruptedError",
    "CaptureResult",
    "CheckResult",
    "Client",
    "ConflictError",
    "CredentialError",
    "Estimate",
    "ExportedFile",
    "MissingPackageError",
    "NotFoundError",
    "ProblemError",
    "QuotaError",
    "Recording",
    "Rig",
    "ServiceUnavailableError",
    "UsageError",
    "offline",
    "open_camera",
]


def __getattr__(name: str) -> Any:
    """Import the module of a public name."""
    if name == "offline":
        return import_module(".offline", __name__)
    for module, names in _NAMES.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
