"""File formats of other tools, by name."""

import re
from dataclasses import replace
from functools import partial

import numpy as np

from .. import deadline
from .. import image_transform as transforms
from ..errors import CalibrationError
from . import (
    artoolkit,
    colmap,
    dng,
    gyroflow,
    kalibr,
    lensfun,
    mrcal,
    native,
    opencv,
    opensfm,
    photonvision,
    ros,
    web,
)
from .base import MAX_INVISIBLE_PX, Conversion, ExportedFile, ExportSource, ImportedFile, ModelConstraint
from .format import Format

FORMATS: dict[str, Format] = {
    form.name: form
    for form in (
        native.NativeJson(),
        opencv.OpenCvYaml(),
        opencv.OpenCvJson(),
        ros.Ros(),
        kalibr.Kalibr(),
        colmap.Colmap(),
        opensfm.OpenSfm(),
        mrcal.Mrcal(),
        mrcal.CornersVnl(),
        gyroflow.Gyroflow(),
        lensfun.Lensfun(),
        dng.Dng(),
        web.WebXr(),
        web.Gltf(),
        photonvision.PhotonVision(),
        artoolkit.ArToolKit(),
    )
}
FORMAT_NAMES = tuple(FORMATS)
MAX_CONVERSION_S = 2.5
"""Time for a conversion, where the time is limited: of a picture that people take it is a fifth of it."""
MIN_SIDE_PX = 16

__all__ = [
    "FORMATS",
    "FORMAT_NAMES",
    "MAX_INVISIBLE_PX",
    "Conversion",
    "ExportSource",
    "ExportedFile",
    "Format",
    "ImportedFile",
    "ModelConstraint",
    "write",
]


def write(source: ExportSource, name: str, transform: transforms.Transform | None = None) -> ExportedFile:
    """Write a calibration as the file called `name`, of the transformed picture if a transform is given.

    Raises CalibrationError ``unknown_format``, or ``not_representable`` if the format cannot hold it.
    """
    form = FORMATS.get(name)
    if form is None:
        raise CalibrationError(
            "unknown_format", f"no format is called {name!r}; there are {', '.join(FORMAT_NAMES)}"
        )
    width, height = transform.img_size if transform is not None else source.camera.img_size
    if min(width, height) < MIN_SIDE_PX:
        raise CalibrationError(
            "not_representable", f"of a picture of {width} x {height} px no lens can be determined"
        )
    try:
        result = deadline.compute_within(MAX_CONVERSION_S, partial(_convert, form, source, transform), None)
        if result is None:
            raise CalibrationError("not_representable", "no camera that it can hold was found in time")
        source, conversion = result
        content = form.write(source, conversion)
    except np.linalg.LinAlgError:
        raise CalibrationError(
            "not_representable", "this part of the picture leaves the camera undetermined"
        ) from None
    # Several formats are YAML: files of one camera are to lie side by side.
    kind = "" if name == native.NativeJson.name else f"-{name}"
    return ExportedFile(
        content=content,
        media_type=form.media_type,
        filename=f"{slug(source.name)}-{width}x{height}{kind}{form.suffix}",
        error=conversion.error,
        coverage=conversion.coverage,
        warning=conversion.warning,
    )


def _convert(
    form: Format, source: ExportSource, transform: transforms.Transform | None
) -> tuple[ExportSource, Conversion]:
    """Return the source of the transformed picture and its conversion.

    A turn or reflection must not change which camera is found: the upright picture is converted, then turned.
    """
    if transform is None:
        return source, form.check(form.convert(source))
    upright, turn = transform.split()
    source = transform_source(source, upright)
    conversion = form.convert(source)
    conversion = replace(conversion, camera=turn.camera(conversion.camera))
    return transform_source(source, turn), form.check(conversion)


def transform_source(source: ExportSource, transform: transforms.Transform) -> ExportSource:
    """Transform camera and measurements.

    A mirrored board has its corners at the places of the board's own: the rightmost become the leftmost.
    """
    camera, views = transforms.apply(transform, source.camera, source.views)
    if transform.mirrored and source.board is not None:
        shift = (float(source.board.size[0]), 0.0, 0.0)
        views = tuple(replace(view, object_points=view.object_points + shift) for view in views)
    return replace(source, camera=camera, views=views)


def slug(name: str) -> str:
    """Return a name that is safe as a file's."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "camera"
