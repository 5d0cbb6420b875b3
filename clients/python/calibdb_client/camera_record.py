"""A camera in a record of the service: of a calibration, or of an estimate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

import calibsolver
from calibsolver.arrays import Array

from .errors import UsageError


@dataclass(frozen=True, eq=False)
class CameraRecord:
    """A camera.

    Attributes
    ----------
    record
        All that the service answered, under its names (docs/api.md).
    """

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
        """The camera model, of which `project` and `unproject` of a calibration are shorthands.

        Raises UsageError for a model that this version does not know.
        """
        try:
            return calibsolver.Camera.from_record(self.record)
        except calibsolver.CalibrationError as error:
            upgrade = ": upgrade calibdb-client" if error.code == "unknown_model" else ""
            raise UsageError(f"{error}{upgrade}") from None
