"""Files of other tools, written and read on this machine by calibsolver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibsolver import CalibrationError, Camera, formats
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.reading import read_bytes

from .errors import UsageError
from .files import UNCHANGED, ExportedFile, PictureChange, read_whole

if TYPE_CHECKING:
    from .recording import Recording

NATIVE = "calibdb"
RIG_NATIVE = "json"
FORMATS = formats.FORMAT_NAMES
RIG_FORMATS = ("json", "opencv_stereo", "ros", "kalibr", "colmap", "mrcal", "gltf")
_YAML = (".yaml", ".yml")
_SUFFIXES = {
    **{name: (formats.FORMATS[name].suffix,) for name in FORMATS},
    **dict.fromkeys(("ros", "kalibr", "opencv-yaml"), _YAML),
}
_RIG_SUFFIXES = {
    **dict.fromkeys(("ros", "colmap", "mrcal"), (".zip",)),
    "opencv_stereo": (".zip", *_YAML),
    "json": (".json",),
    "kalibr": _YAML,
    "gltf": (".gltf",),
}
_SUFFIX_DEFAULTS = {".json": NATIVE, ".xml": "lensfun", ".txt": "colmap"}
"""Formats of suffixes that several tools use, where one is meant unless another is named."""
_RIG_DEFAULTS = {".json": RIG_NATIVE, ".yaml": "kalibr", ".yml": "kalibr"}
_ALIASES = {"opencv": "opencv-yaml"}
_UNWRITTEN = ("recording", "report", "covariance", "board", "camera_key")
"""Members of a record that its files do not have."""


def format_of(name: str | None, path: str | Path | None, rig: bool = False) -> str:
    """Return the format that a name, or the suffix of a path, says.

    Raises UsageError if the suffix stands for several formats and none is named, if name and suffix
    contradict each other, or if there is no such format.
    """
    formats, suffixes = (RIG_FORMATS, _RIG_SUFFIXES) if rig else (FORMATS, _SUFFIXES)
    suffix = Path(path).suffix.lower() if path is not None and str(path) != "-" else ""
    if name is not None and not rig:
        name = _ALIASES.get(name, name) if suffix != ".json" else {"opencv": "opencv-json"}.get(name, name)
    if name is not None and name not in formats:
        raise UsageError(f"no format is called {name!r}; there are {', '.join(formats)}")
    candidates = [each for each in formats if suffix in suffixes[each]]
    if name is None:
        default = (_RIG_DEFAULTS if rig else _SUFFIX_DEFAULTS).get(suffix)
        if not suffix:
            return RIG_NATIVE if rig else NATIVE
        if default or len(candidates) == 1:
            return default or candidates[0]
        if candidates:
            raise UsageError(f"{suffix} is the suffix of several formats: say --format {_or(candidates)}")
        raise UsageError(f"no format has the suffix {suffix!r}: say --format, one of {', '.join(formats)}")
    if candidates and name not in candidates:
        raise UsageError(
            f"{path} has the suffix of {_or(candidates)}, and the format is {name!r}, "
            f"whose files end in {_or(suffixes[name])}"
        )
    return name


def write(
    record: Mapping[str, Any],
    name: str,
    recording: Recording | None = None,
    change: PictureChange = UNCHANGED,
) -> ExportedFile:
    """Write a calibration's record as a file of another tool, for the changed picture.

    A format that lacks its model is fitted to the corners of the recording. Raises UsageError if the format
    does not support the camera.
    """
    try:
        camera = Camera.from_record(record)
        source = formats.ExportSource(
            camera=camera,
            views=tuple(recording.observations()) if recording else (),
            board=recording.board if recording else None,
            name=str(record.get("camera") or "camera"),
            identifier=str(record.get("id") or ""),
            rms=float(record.get("avg_reprojection_error") or 0.0),
            time=int(record.get("calibration_time") or 0),
            record={key: value for key, value in record.items() if key not in _UNWRITTEN},
        )
        transform = None if change == UNCHANGED else change.transform(camera.img_size)
        return _exported(formats.write(source, name, transform))
    except CalibrationError as error:
        raise UsageError(str(error)) from None


def write_rig(record: Mapping[str, Any], name: str) -> ExportedFile:
    """Write a rig's record as a file of another tool. Raises UsageError if the format does not support it."""
    from calibsolver.rig import formats as rig_formats

    calibrations = record["calibrations"]
    try:
        source = rig_formats.RigSource(
            cameras=[Camera.from_record(each) for each in calibrations],
            poses=np.array([[*each["rvec"], *each["tvec"]] for each in record["extrinsics"]]),
            unit=str(record["unit"]),
            names=[f"cam{i} {each.get('camera', '')}".strip() for i, each in enumerate(calibrations)],
            identifier=str(record.get("rig_id") or ""),
            record=record,
        )
        return _exported(rig_formats.write(source, {"opencv_stereo": "opencv-yaml"}.get(name, name)))
    except CalibrationError as error:
        raise UsageError(f"{error}") from None


def read(path: str | Path, options: ReaderOptions = ReaderOptions()) -> dict[str, Any]:  # noqa: B008 - a value that never changes
    """Return the record of the camera in another tool's file. Raises UsageError if there is none."""
    try:
        content = read_whole(Path(path))
        imported = read_bytes(content, Path(path).suffix.lower(), options)
    except CalibrationError as error:
        raise UsageError(f"{path}: {error}") from None
    camera = imported.camera
    if camera is None:
        raise UsageError(f"{path} has corners and no calibration: calibrate from its pictures")
    record: dict[str, Any] = {
        "camera": " ".join(imported.name.split()) or Path(path).stem,
        **camera.record(),
    }
    if imported.error:
        record["approximation"] = f"the closest {camera.model} camera, up to {imported.error:.2f} px off"
    return record | ({"cameras": list(imported.cameras)} if imported.cameras else {})


def _exported(file: formats.ExportedFile) -> ExportedFile:
    return ExportedFile(
        file.content, file.filename, file.media_type, file.error, file.coverage, file.warning or ""
    )


def _or(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
