"""A camera: model, intrinsics, image size."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import models
from .arrays import Array, Mask, frozen
from .errors import CalibrationError

DOMAIN_GRID = (40, 30)


@dataclass(frozen=True)
class Domain:
    """Largest angle from the axis, radians, in the one-to-one domain, and share of the image within."""

    angle: float
    covered: float


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera.

    Attributes
    ----------
    model
        Name of the distortion model.
    matrix
        (3, 3) camera matrix, px, zero skew.
    distortion
        (m,) coefficients in the model's order.
    img_size
        Width and height, px.
    """

    model: str
    matrix: Array
    distortion: Array
    img_size: tuple[int, int]

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", frozen(self.matrix))
        object.__setattr__(self, "distortion", frozen(self.distortion))
        object.__setattr__(self, "img_size", (int(self.img_size[0]), int(self.img_size[1])))
        size = len(models.get(self.model).coefficients)
        if self.matrix.shape != (3, 3) or self.distortion.shape != (size,):
            raise CalibrationError("bad_camera", f"{self.model} has a 3x3 matrix and {size} coefficients")

    @classmethod
    def from_intrinsics(cls, model: str, k: Array, img_size: tuple[int, int]) -> "Camera":
        """Camera of intrinsics (p,): fx fy cx cy, then the distortion."""
        matrix = np.array([[k[0], 0, k[2]], [0, k[1], k[3]], [0, 0, 1]])
        return cls(model, matrix, k[4:], img_size)

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "Camera":
        """Camera of a calibration record (see `Calibration.record`)."""
        w, h = record["img_size"]
        return cls(
            str(record["distortion_model"]),
            np.asarray(record["camera_matrix"], dtype=np.float64),
            np.asarray(record["distortion_coefficients"], dtype=np.float64),
            (w, h),
        )

    def record(self) -> dict[str, Any]:
        """Members of a calibration record that `from_record` reads."""
        return {
            "img_size": list(self.img_size),
            "camera_matrix": self.matrix.tolist(),
            "distortion_coefficients": self.distortion.tolist(),
            "distortion_model": self.model,
        }

    @property
    def intrinsics(self) -> Array:
        """(p,): fx fy cx cy, then the distortion."""
        m = self.matrix
        return np.concatenate([[m[0, 0], m[1, 1], m[0, 2], m[1, 2]], self.distortion])

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths along x and y: px per radian at the axis (see `Model.focal`)."""
        fx, fy = models.get(self.model).focal(self.intrinsics).tolist()
        return fx, fy

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) in the camera frame; NaN where the model is not one-to-one."""
        model, k = models.get(self.model), self.intrinsics
        p, shape = rows(points, 3)
        with np.errstate(all="ignore"):  # what lies behind the camera is masked out
            q = np.where(model.valid(k[4:], p), model.project(k, p), np.nan)
        return np.ascontiguousarray(q.T).reshape(*shape, 2)

    def unproject(self, pixels: Array) -> Array:
        """Unit rays (n, 3), camera frame, of pixels (n, 2); NaN where the valid domain has none."""
        q, shape = rows(pixels, 2)
        rays = models.get(self.model).unproject(self.intrinsics, q)
        return np.ascontiguousarray(rays.T).reshape(*shape, 3)

    def valid(self, points: Array) -> Mask:
        """True if points (n, 3), camera frame, lie where the model is one-to-one."""
        p, shape = rows(points, 3)
        return models.get(self.model).valid(np.asarray(self.distortion), p).reshape(shape)

    def domain(self) -> Domain:
        """Domain in which the model is one-to-one, and its share of the image."""
        rays = models.get(self.model).unproject(self.intrinsics, pixel_grid(self.img_size, DOMAIN_GRID))
        angle = models.get(self.model).domain_half_angle(np.asarray(self.distortion))
        return Domain(float(angle), float(np.isfinite(rays[0]).mean()))


def pixel_grid(img_size: tuple[int, int], grid: tuple[int, int]) -> Array:
    """Centres (2, rows, columns) px of `grid` = (columns, rows) equal cells of the image."""
    (w, h), (columns, rows) = img_size, grid
    x = (np.arange(columns) + 0.5) * w / columns - 0.5
    y = (np.arange(rows) + 0.5) * h / rows - 0.5
    return np.stack(np.meshgrid(x, y))


def rows(values: object, width: int) -> tuple[Array, tuple[int, ...]]:
    """Values (..., width) as (width, n), and the shape in front; ValueError for any other shape."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape == (0,):  # an empty list
        array = array.reshape(0, width)
    if array.shape[-1:] != (width,):
        raise ValueError(f"an array (n, {width}) is wanted, not {array.shape}")
    return array.reshape(-1, width).T, array.shape[:-1]
