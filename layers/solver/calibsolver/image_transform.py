"""Calibration of a resized, cropped, turned or mirrored picture.

The centre of the top-left pixel is (0, 0), its corner (-1/2, -1/2). A resize multiplies corners: hence the
halves.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from . import models
from .arrays import Array
from .camera import Camera
from .errors import CalibrationError
from .view import View

MAX_SIDE_PX = 65_536


@dataclass(frozen=True, eq=False)
class Transform:
    """An axis-aligned map of pixels, q' = linear q + offset, to a picture of `img_size`.

    The linear part (2, 2) scales, mirrors and turns by quarters.
    """

    linear: Array
    offset: Array
    img_size: tuple[int, int]

    @property
    def mirrored(self) -> bool:
        """True if left and right are swapped."""
        return float(np.linalg.det(self.linear)) < 0

    def pixels(self, q: Array) -> Array:
        """Carry pixels (n, 2) along."""
        return np.asarray(q, dtype=np.float64) @ self.linear.T + self.offset

    def view(self, view: View) -> View:
        """Carry a view along; its points may leave the picture."""
        return replace(view, image_points=self.pixels(view.image_points))

    def camera(self, camera: Camera) -> Camera:
        """Camera of the transformed picture.

        A turn or a reflection T of the picture is one of the camera's frame. Radial terms do not notice;
        tangential ones (p2, p1) turn as a vector does.
        """
        f = np.abs(self.linear) @ (camera.matrix[0, 0], camera.matrix[1, 1])
        axes = np.sign(self.linear)
        matrix = np.array([[f[0], 0, 0], [0, f[1], 0], [0, 0, 1.0]])
        matrix[:2, 2] = self.linear @ camera.matrix[:2, 2] + self.offset
        d = np.array(camera.distortion)
        names = models.get(camera.model).coefficients
        if "p1" in names:
            p1, p2 = names.index("p1"), names.index("p2")
            d[p2], d[p1] = axes @ (d[p2], d[p1])
        return Camera(camera.model, matrix, d, self.img_size)

    def then(self, following: "Transform") -> "Transform":
        """Both transforms, `following` last."""
        return Transform(
            following.linear @ self.linear,
            following.linear @ self.offset + following.offset,
            following.img_size,
        )

    def split(self) -> tuple["Transform", "Transform"]:
        """Two transforms that make this one: a crop and resize, then a turn or reflection."""
        axes = np.sign(self.linear)
        w, h = (int(n) for n in np.abs(axes.T) @ self.img_size)
        corner = np.where(axes.sum(axis=1) < 0, np.array(self.img_size) - 1.0, 0.0)
        upright = Transform(axes.T @ self.linear, axes.T @ (self.offset - corner), (w, h))
        return upright, Transform(axes, corner, self.img_size)


def identity(img_size: tuple[int, int]) -> Transform:
    """Leave the picture as it is."""
    return Transform(np.eye(2), np.zeros(2), _size(img_size))


def resize(img_size: tuple[int, int], to: tuple[int, int]) -> Transform:
    """Resample the whole picture to another size.

    Only right if the smaller picture is the larger one scaled down: a camera's own resolutions may differ in
    their field of view.
    """
    s = np.array(_size(to)) / _size(img_size)
    return Transform(np.diag(s), s / 2 - 0.5, _size(to))


def crop(img_size: tuple[int, int], corner: tuple[int, int], size: tuple[int, int]) -> Transform:
    """Cut a part out, from `corner` on.

    Raises CalibrationError ``out_of_range`` if it exceeds the picture.
    """
    (w, h), (x, y) = _size(size), corner
    if not (x >= 0 and y >= 0 and x + w <= img_size[0] and y + h <= img_size[1]):
        raise CalibrationError(
            "out_of_range", f"{w} x {h} px at {x}, {y} do not lie inside {img_size[0]} x {img_size[1]} px"
        )
    return Transform(np.eye(2), -np.array([x, y], dtype=np.float64), (w, h))


def rotate(img_size: tuple[int, int], degrees: int) -> Transform:
    """Turn the picture clockwise by a multiple of 90 degrees; else CalibrationError ``out_of_range``."""
    if degrees % 90:
        raise CalibrationError(
            "out_of_range", f"a picture is turned by 0, 90, 180 or 270 degrees, not {degrees}"
        )
    turned = identity(img_size)
    for _ in range(degrees // 90 % 4):
        w, h = turned.img_size
        turned = turned.then(Transform(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([h - 1.0, 0.0]), (h, w)))
    return turned


def mirror(img_size: tuple[int, int]) -> Transform:
    """Swap left and right."""
    w, h = _size(img_size)
    return Transform(np.diag([-1.0, 1.0]), np.array([w - 1.0, 0.0]), (w, h))


def apply(transform: Transform, camera: Camera, views: Sequence[View]) -> tuple[Camera, tuple[View, ...]]:
    """Carry a camera and its views along.

    The camera of a reflected picture sees the board as in a mirror: the board's points are reflected too, so
    that they fit the camera again.
    """
    moved = [transform.view(view) for view in views]
    if transform.mirrored:
        moved = [replace(view, object_points=view.object_points * (-1.0, 1.0, 1.0)) for view in moved]
    return transform.camera(camera), tuple(moved)


def _size(size: tuple[int, int]) -> tuple[int, int]:
    w, h = int(size[0]), int(size[1])
    if not (1 <= w <= MAX_SIDE_PX and 1 <= h <= MAX_SIDE_PX):
        raise CalibrationError("out_of_range", f"a picture of {w} x {h} px is none")
    return w, h
