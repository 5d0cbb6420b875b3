"""Priors for structure from motion: the cameras of a folder of photographs, calibrated or estimated."""

import json
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import exif
from .calibration import Answer, Calibration, Estimate
from .errors import UsageError
from .exif import Photograph
from .key import CameraKey
from .pictures import PLATFORM, SUFFIXES

_FILM_WIDTH_MM = 36.0
_END = "END-OF-PHOTOGRAPHS"  # of a list in the shell script


@dataclass(frozen=True)
class PhotoGroup:
    """Photographs of one camera, size and focal length, and what the database says of it."""

    photo: Photograph
    paths: tuple[Path, ...]
    answer: Answer

    @property
    def camera(self) -> Calibration | Estimate:
        """Camera to begin with. Raises UsageError if there is none of this size."""
        camera = self.answer.calibration or self.answer.estimate
        if camera is None:
            raise UsageError(f"the service says nothing of {self.photo.label}: is it an older one?")
        if camera.img_size != self.photo.size:
            w, h = camera.img_size
            raise UsageError(f"{self.photo.label} is calibrated at {w}x{h} only: cameras crop at other sizes")
        return camera

    @property
    def title(self) -> str:
        """Camera, number of photographs, size, focal length and certainty."""
        w, h = self.photo.size
        count = f"{len(self.paths)} photograph{'s' if len(self.paths) > 1 else ''}"
        facts = [self.photo.label, count, f"{w}x{h}", f"{self.photo.focal_mm:g} mm"]
        estimate = self.answer.estimate
        if self.answer.calibration is not None or estimate is None:
            return ", ".join([*facts, "calibrated"])
        low, high = estimate.interval_90
        return ", ".join([*facts, f"estimated ({estimate.basis}), 90 %: {low:.1f} to {high:.1f} degrees"])


def photographs(folder: Path) -> dict[Photograph, list[Path]]:
    """Group the photographs of a folder by camera, size and focal length. Raises UsageError for none."""
    if not folder.is_dir():
        raise UsageError(f"{folder} is not a folder")
    groups: dict[Photograph, list[Path]] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in SUFFIXES:
            continue
        try:
            groups.setdefault(exif.read(path), []).append(path)
        except UsageError:  # edited, or a screenshot: it says nothing of a camera
            continue
    if not groups:
        raise UsageError(f"no photograph in {folder} names its camera: they have no EXIF data")
    return groups


def look_up(
    groups: Mapping[Photograph, Sequence[Path]],
    lookup: Callable[[CameraKey, Mapping[str, float]], Answer],
) -> list[PhotoGroup]:
    """Look up the camera of each group."""
    found = []
    for photo, paths in groups.items():
        key = CameraKey(photo.label, PLATFORM, photo.size, photo.focal_mm)
        found.append(PhotoGroup(photo, tuple(paths), lookup(key, photo.reported)))
    return found


def colmap(groups: Sequence[PhotoGroup]) -> str:
    """Return a shell script with COLMAP's commands: a camera per group, fixed if all are calibrated."""
    lines = [
        "#!/bin/sh",
        "# $1: the database, $2: the folder of photographs, $3: the folder of the result",
        "set -e",
    ]
    for number, group in enumerate(groups, 1):
        names = "\n".join(path.name for path in group.paths if path.name.isprintable() and path.name != _END)
        model, parameters = _colmap_camera(group.camera)
        lines += [
            f"# {group.title}",
            f"cat > priors-{number}.txt <<'{_END}'\n{names}\n{_END}",
            'colmap feature_extractor --database_path "$1" --image_path "$2" '
            f"--image_list_path priors-{number}.txt --ImageReader.single_camera 1 "
            f"--ImageReader.camera_model {model} --ImageReader.camera_params {shlex.quote(parameters)}",
        ]
    fixed = all(group.answer.calibration is not None for group in groups)
    refine = " --Mapper.ba_refine_focal_length 0 --Mapper.ba_refine_extra_params 0" if fixed else ""
    lines += [
        'colmap exhaustive_matcher --database_path "$1"',
        f'colmap mapper --database_path "$1" --image_path "$2" --output_path "$3"{refine}',
    ]
    return "\n".join(lines) + "\n"


def _colmap_camera(camera: Calibration | Estimate) -> tuple[str, str]:
    """Return COLMAP's model and its parameters; of an estimate without distortion one to begin with."""
    from calibsolver.formats.colmap import parameters

    if camera.distortion_model == "omnidirectional":
        raise UsageError("COLMAP has no model for an omnidirectional camera: look up --model fisheye")
    model, values = parameters(camera.lens)
    if isinstance(camera, Estimate) and camera.distortion_model == "rectilinear":
        fx, _, cx, cy = values[:4]
        model, values = "SIMPLE_RADIAL", [fx, cx, cy, 0.0]
    return model, ",".join(f"{value:.8g}" for value in values)


def opensfm(groups: Sequence[PhotoGroup]) -> str:
    """Return `camera_models_overrides.json` for OpenSfM, under the names that it gives to cameras."""
    from calibsolver.formats.opensfm import members

    cameras = {}
    for group in groups:
        camera = group.camera
        if camera.distortion_model not in ("rectilinear", "fisheye"):
            raise UsageError(f"OpenSfM has no {camera.distortion_model} model: look up --model rectilinear")
        cameras[_opensfm_name(group.photo)] = members(camera.lens)
    return json.dumps(cameras, indent=4) + "\n"


def _opensfm_name(photo: Photograph) -> str:
    """Name of a camera in OpenSfM (`opensfm.exif.camera_id_`), by its default projection type.

    A lens that the file names stands for the model.
    """
    model = photo.lens or photo.model
    model = model.replace(photo.make, "") if photo.make else model
    focal = str(float(photo.focal_35mm / _FILM_WIDTH_MM))[:6]
    w, h = photo.size
    return " ".join(["v2", photo.make.strip(), model.strip(), str(w), str(h), "perspective", focal]).lower()


def _sensor_widths(line: str, groups: Iterable[PhotoGroup]) -> str:
    """Return a line of a database for each make, model and width (mm).

    By the width the focal length in mm becomes that in pixels.
    """
    widths = {}
    for group in groups:
        photo, matrix = group.photo, group.camera.camera_matrix
        if photo.focal_mm > 0:
            names = photo.make.replace(";", " "), photo.model.replace(";", " ")
            widths[names] = float(photo.focal_mm * max(photo.size) / matrix[0, 0])
    if not widths:
        raise UsageError("no photograph has a focal length in its EXIF data, which this program needs")
    return "".join(line.format(*names, width) for names, width in widths.items())


openmvg = partial(_sensor_widths, "{} {};{:.4f}\n")
meshroom = partial(_sensor_widths, "{};{};{:.4f};calibDB\n")
WRITERS: dict[str, Callable[[Sequence[PhotoGroup]], str]] = {
    "colmap": colmap,
    "opensfm": opensfm,
    "openmvg": openmvg,
    "meshroom": meshroom,
}
