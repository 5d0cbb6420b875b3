"""Calibrations, estimates and answers to lookups as the service returns them, and their use."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

import calibsolver
from calibsolver import undistortion
from calibsolver.arrays import Array

from .errors import MissingPackageError, UsageError
from .files import UNCHANGED, ExportedFile, PictureChange, read_object, write_whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .recording import Recording

Exporter = Callable[[str, str], ExportedFile]
"""Fetches the file of an id, of a calibration or rig, in a format."""

Maker = Callable[[Mapping[str, Any]], "Calibration"]
_NATIVE = "calibdb"
Source = Literal["cache", "edge", "service"]


@dataclass(frozen=True, eq=False)
class CameraRecord:
    """A camera; `record` is all that the service answered, under its names (docs/api.md)."""

    record: Mapping[str, Any]

    @cached_property
    def camera_matrix(self) -> Array:
        """(3, 3), px."""
        return np.array(self.record["camera_matrix"], dtype=np.float64)

    @cached_property
    def distortion_coefficients(self) -> Array:
        """(m,), in the model's order."""
        return np.array(self.record["distortion_coefficients"], dtype=np.float64)

    @property
    def distortion_model(self) -> str:
        """One of `rectilinear`, `fisheye`, `rational`, `omnidirectional`."""
        return str(self.record["distortion_model"])

    @property
    def img_size(self) -> tuple[int, int]:
        """Width and height, px."""
        w, h = self.record["img_size"]
        return int(w), int(h)

    @cached_property
    def lens(self) -> calibsolver.Camera:
        """The camera model. Raises UsageError for a model that this version does not know."""
        try:
            return calibsolver.Camera.from_record(self.record)
        except calibsolver.CalibrationError as error:
            upgrade = ": upgrade calibdb-client" if error.code == "unknown_model" else ""
            raise UsageError(f"{error}{upgrade}") from None


@dataclass(frozen=True, eq=False)
class Calibration(CameraRecord):
    """A calibrated camera, and how far to trust it.

    Raises UsageError for a record that is not a calibration.
    """

    _exporter: Exporter | None = field(default=None, repr=False)
    _recording: Recording | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        try:
            w, h = self.record["img_size"]
            matrix = np.asarray(self.record["camera_matrix"], dtype=np.float64)
            distortion = np.asarray(self.record["distortion_coefficients"], dtype=np.float64)
            whole = matrix.shape == (3, 3) and distortion.ndim == 1 and int(w) > 0 and int(h) > 0
            whole = whole and bool(np.isfinite(matrix).all() and np.isfinite(distortion).all())
            whole = whole and isinstance(self.record["distortion_model"], str)
        except (KeyError, TypeError, ValueError):
            whole = False
        if not whole:
            raise UsageError(
                "not a calibration: img_size, camera_matrix and distortion_coefficients are required"
            )

    def __repr__(self) -> str:
        m = self.camera_matrix
        return (
            f"Calibration({self.camera!r}, {self.img_size[0]}x{self.img_size[1]}, {self.distortion_model}, "
            f"fx={m[0, 0]:.1f}, fy={m[1, 1]:.1f}, cx={m[0, 2]:.1f}, cy={m[1, 2]:.1f})"
        )

    @classmethod
    def load(cls, path: str | Path) -> Calibration:
        """Read a JSON file that `save` or the command wrote, or a calibration file of another tool.

        Raises UsageError for any other file.
        """
        record = read_object(Path(path)) or {}
        if {"distortion_model", "camera_matrix", "img_size"} <= record.keys():
            from .recording import Recording

            recording = Recording.of(record) if "recording" in record else None
            return cls({k: v for k, v in record.items() if k != "recording"}, None, recording)
        from . import conversion

        try:
            return cls(conversion.read(path))
        except UsageError as error:
            raise UsageError(f"not a calibration: {error}") from None

    @property
    def camera(self) -> str:
        """Label of the camera."""
        return str(self.record.get("camera", ""))

    @property
    def recording(self) -> Recording | None:
        """Corners that it was made of, if they are known here."""
        return self._recording

    @property
    def id(self) -> str | None:
        """Id at the service; None if it is interpolated, refitted, or made offline."""
        return self.record.get("id")

    @property
    def uncertainty(self) -> dict[str, float]:
        """Predicted error of a projection over the image, px: `rms` and `max`."""
        return dict(self.record.get("uncertainty") or {})

    @property
    def covariance(self) -> Array | None:
        """(p, p) of fx, fy, cx, cy and the distortion; None if the record has none, as that of a lookup."""
        rows = self.record.get("covariance")
        return None if rows is None else np.array(rows, dtype=np.float64)

    @property
    def avg_reprojection_error(self) -> float:
        """px, root of the mean square over all measurements; NaN if the file does not say."""
        return float(self.record.get("avg_reprojection_error", "nan"))

    @property
    def reliable(self) -> bool:
        """True if enough calibrations agree."""
        return bool(self.record.get("reliable"))

    @property
    def exact_size(self) -> bool:
        """True if this is the requested size; otherwise never rescale it blindly."""
        return bool(self.record.get("exact_size", True))

    def project(self, points: object) -> Array:
        """Pixels (n, 2) of points (n, 3), camera frame; NaN where the lens sees nothing."""
        return self.lens.project(_rows(points, 3))

    def unproject(self, pixels: object) -> Array:
        """Return unit rays (n, 3), camera frame, of pixels (n, 2); NaN where there are none."""
        return self.lens.unproject(_rows(pixels, 2))

    def new_camera_matrix(self, alpha: float = 0.0, size: Sequence[int] | None = None) -> Array:
        """Return the matrix (3, 3) of a rectified picture: at 0 it has no black pixel, at 1 it loses none."""
        try:
            return undistortion.new_camera_matrix(self.lens, alpha, size)
        except calibsolver.CalibrationError as error:
            raise UsageError(str(error)) from None

    def remap_tables(
        self, matrix: object = None, size: Sequence[int] | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the tables (h, w) for `cv2.remap`: the place in the picture of every rectified pixel.

        `matrix` (3, 3) and `size`, px, are those of the rectified picture; by default the calibration's own.
        """
        try:
            return undistortion.remap_tables(self.lens, matrix, size)
        except calibsolver.CalibrationError as error:
            raise UsageError(str(error)) from None

    @cached_property
    def _own_tables(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        return self.remap_tables()

    def undistort(self, frame: Any, matrix: object = None, size: Sequence[int] | None = None) -> Any:
        """Return the rectified picture of a frame (h, w) or (h, w, c) by `remap_tables`; needs OpenCV.

        Raises UsageError if the frame has another size.
        """
        h, w = frame.shape[:2]
        if (w, h) != self.img_size:
            raise UsageError(
                f"the frame has {w} x {h} px, the calibration is of {self.img_size[0]} x {self.img_size[1]}: "
                "look the camera up at the frame's size"
            )
        try:
            import cv2
        except ImportError:
            raise MissingPackageError("undistort() needs OpenCV: pip install opencv-python") from None
        tables = self._own_tables if matrix is None and size is None else self.remap_tables(matrix, size)
        return cv2.remap(frame, *tables, cv2.INTER_LINEAR)

    def camera_info(self) -> dict[str, Any]:
        """Return the fields of a ROS message `sensor_msgs/CameraInfo` (all but the header).

        Raises UsageError for a model that ROS does not have.
        """
        from calibsolver.formats.ros import ROS_MODELS

        name = ROS_MODELS.get(self.distortion_model)
        if name is None:
            raise UsageError(
                f"ROS has no model {self.distortion_model}: save(…, format='ros') writes the nearest one"
            )
        k = self.camera_matrix
        projection = np.hstack([k, np.zeros((3, 1))])
        w, h = self.img_size
        return {
            "width": w,
            "height": h,
            "distortion_model": name,
            "d": self.distortion_coefficients.tolist(),
            "k": k.ravel().tolist(),
            "r": np.eye(3).ravel().tolist(),
            "p": projection.ravel().tolist(),
        }

    def save(self, path: str | Path, format: str | None = None) -> ExportedFile:  # noqa: A002 - the contract's name
        """Write a file of one of the formats of docs/formats.md, as a whole or not at all, and return it.

        Without a format the suffix of the path says it; one that contradicts the suffix raises UsageError.
        """
        from . import conversion

        file = self.export(conversion.format_of(format, path))
        write_whole(Path(path), file.content)
        return file

    def export(self, format: str = _NATIVE, change: PictureChange = UNCHANGED) -> ExportedFile:  # noqa: A002
        """Return the file in one of the formats of docs/formats.md, for the changed picture.

        The service writes its own calibrations, calibsolver all others. Raises UsageError if the format
        cannot hold the camera.
        """
        if format == _NATIVE and change == UNCHANGED:
            content = json.dumps(dict(self.record), indent=2, ensure_ascii=False) + "\n"
            return ExportedFile(content.encode(), "calibration.json", "application/json")
        if self.id and self._exporter and change == UNCHANGED:
            return self._exporter(self.id, format)
        from . import conversion

        return conversion.write(self.record, format, self._recording, change)


def _rows(values: object, width: int) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != width:
        raise UsageError(f"an array (n, {width}) is wanted, not {array.shape}")
    return array.reshape(-1, width)


@dataclass(frozen=True)
class Answer:
    """Answer to a lookup.

    Attributes
    ----------
    calibration
        None if nothing reliable is known.
    reason
        Word for why there is none: ``unknown_camera``, ``too_few``, ``disagree``, ``few_contributors`` or
        ``imprecise``; else "".
    detail
        The reason in a sentence.
    guidance_url
        Page that calibrates the camera in a browser; "" if there is a calibration.
    source
        Place of the answer: this machine's cache, the edge, or the service.
    estimate
        Likely camera; None if there is a calibration.
    """

    calibration: Calibration | None
    reason: str = ""
    detail: str = ""
    guidance_url: str = ""
    source: Source = "service"
    estimate: Estimate | None = None


@dataclass(frozen=True, eq=False)
class Estimate(CameraRecord):
    """Estimated camera with the interval of its field of view (docs/estimates.md).

    Its model is `rectilinear` or `fisheye`, or that of a calibration that it rests on.

    Raises UsageError for a record that is not an estimate.
    """

    def __post_init__(self) -> None:
        try:
            low, high = self.record["interval_90"]["hfov_deg"]
            whole = float(low) <= float(self.record["hfov_deg"]) <= float(high)
            whole = whole and np.asarray(self.record["camera_matrix"], dtype=np.float64).shape == (3, 3)
        except (KeyError, TypeError, ValueError):
            whole = False
        if not whole:
            raise UsageError("not an estimate: camera_matrix, hfov_deg and interval_90 are needed")

    def __repr__(self) -> str:
        low, high = self.interval_90
        return f"Estimate({self.hfov_deg:.1f} degrees, 90 %: {low:.1f} to {high:.1f}, {self.basis})"

    @property
    def hfov_deg(self) -> float:
        """Horizontal field of view, degrees."""
        return float(self.record["hfov_deg"])

    @property
    def interval_90(self) -> tuple[float, float]:
        """Horizontal fields of view, degrees, between which the true one lies with a probability of 90 %."""
        low, high = self.record["interval_90"]["hfov_deg"]
        return float(low), float(high)

    @property
    def basis(self) -> str:
        """Best evidence of the estimate, such as `published` or `population`."""
        return str(self.record.get("basis", ""))

    @property
    def group(self) -> str | None:
        """Name of the group of calibrations that fits the views sent, such as ``78°``; None otherwise."""
        group = self.record.get("group")
        return None if group is None else str(group)

    @property
    def sources(self) -> tuple[tuple[str, str], ...]:
        """Titles and addresses of the publications that it rests on."""
        return tuple((str(each["title"]), str(each["url"])) for each in self.record.get("sources", ()))
