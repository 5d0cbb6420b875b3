"""File formats of other tools, by name. A new one is a class in its own module and a line in the registry."""

import re
from dataclasses import replace

from .. import image_transform as transforms
from ..errors import CalibrationError
from ..view import View
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
from .base import VISIBLE, Conversion, Read, Shape, Subject, Written
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

__all__ = [
    "FORMATS",
    "FORMAT_NAMES",
    "VISIBLE",
    "Conversion",
    "Format",
    "Read",
    "Shape",
    "Subject",
    "Written",
    "write",
]


def write(subject: Subject, name: str, transform: transforms.Transform | None = None) -> Written:
    """Write a calibration as the file called `name`, of the transformed picture where one is given.

    Raises CalibrationError ``unknown_format``, or ``not_representable`` where the format cannot hold it.
    """
    form = FORMATS.get(name)
    if form is None:
        raise CalibrationError(
            "unknown_format", f"no format is called {name!r}; there are {', '.join(FORMAT_NAMES)}"
        )
    if transform is not None:
        subject = moved(subject, transform)
    held = form.convert(subject)
    width, height = subject.camera.img_size
    # Several formats are YAML: files of one camera are to lie side by side.
    kind = "" if name == native.NativeJson.name else f"-{name}"
    return Written(
        content=form.write(subject, held),
        media_type=form.media_type,
        filename=f"{slug(subject.name)}-{width}x{height}{kind}{form.suffix}",
        error=held.error,
        coverage=held.coverage,
        warning=held.warning,
    )


def moved(subject: Subject, transform: transforms.Transform) -> Subject:
    """Carry camera and measurements along.

    A mirrored board has its corners at the places of the board's own: the rightmost become the leftmost.
    """
    camera, views = transforms.apply(transform, subject.camera, subject.views)
    if transform.mirrored and subject.board is not None:
        shift = (float(subject.board.squares[0]), 0.0, 0.0)
        views = tuple(View(view.object_points + shift, view.image_points) for view in views)
    return replace(subject, camera=camera, views=views)


def slug(name: str) -> str:
    """Return a name that is safe as a file's."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "camera"
