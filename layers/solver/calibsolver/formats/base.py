"""Values that pass between formats and their callers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .. import models
from ..arrays import Mask
from ..board import Board
from ..camera import Camera
from ..view import View

MAX_INVISIBLE_PX = 0.1
"""px: a conversion that is further off says so in the file."""


@dataclass(frozen=True, eq=False)
class ExportSource:
    """Calibration to be written, with the views it was fitted to, if any, and their board if all show one.

    `rms`: px over all measurements; `time`: Unix seconds; `record`: all that the service answers about it.
    """

    camera: Camera
    views: tuple[View, ...] = ()
    board: Board | None = None
    name: str = "camera"
    identifier: str = ""
    rms: float = 0.0
    time: int = 0
    record: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Conversion:
    """The camera that a file holds, and how far it is from the one that was to be written.

    Attributes
    ----------
    error
        px, largest distance between where the two project the same ray, over what is covered.
    coverage
        Share of the image whose rays the file's camera holds (`convert.compare`).
    used
        For each view of the source the points (n,) that the camera was fitted to; empty: all.
    remark
        Limits of the tools that read the file, or "".
    """

    camera: Camera
    error: float = 0.0
    coverage: float = 1.0
    used: tuple[Mask, ...] = ()
    remark: str = ""

    @property
    def warning(self) -> str | None:
        """Note for the reader of the file; None if the conversion cannot be seen."""
        off, said = f"up to {self.error:.2f} px off", ""
        if self.coverage < 0.999:
            share = f"{100 * self.coverage:.0f} % of the image"
            said = f"Approximation: this format holds {share}; there it is {off}."
        elif self.error > MAX_INVISIBLE_PX:
            said = f"Approximation: {off} somewhere in the image."
        return f"{said} {self.remark}".strip() or None


@dataclass(frozen=True)
class ModelConstraint:
    """Cameras that a format can hold: those of a model, perhaps with some coefficients zero, or fx = fy."""

    model: str
    zero: tuple[str, ...] = ()
    equal_focal: bool = False


ANY_MODEL = tuple(ModelConstraint(model) for model in models.NAMES)


@dataclass(frozen=True)
class ExportedFile:
    """A file for download; `error`, `coverage` and `warning` as of `Conversion`."""

    content: bytes
    media_type: str
    filename: str
    error: float
    coverage: float
    warning: str | None


@dataclass(frozen=True, eq=False)
class ImportedFile:
    """Content of a file: a camera, None if it has only measurements, and views on its board, in its unit.

    `cameras` are the names of all in a file with several. `error`: px, largest distance from the projections
    by the file's camera, if calibsolver lacks its model.
    """

    camera: Camera | None
    views: tuple[View, ...] = ()
    name: str = ""
    cameras: tuple[str, ...] = ()
    error: float = 0.0


@dataclass(frozen=True)
class ReaderOptions:
    """Facts that a file may lack: size of the pictures, px; columns and rows of a board with corners.

    `number` is that of the camera in a file with several, from 0. `model` is that of coefficients without a
    name: four are k1 k2 p1 p2, or a fisheye's k1 to k4.
    """

    img_size: tuple[int, int] | None = None
    number: int = 0
    squares: tuple[int, int] | None = None
    model: str = ""
