"""Calibrations as they might come from many people: views of made-up and of published cameras.

And how far predicted errors are from actual ones, by captures of cameras whose truth is known.
"""

import csv
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from calibsolver import Board, CalibrationError, Camera, View, fit, rotation
from calibsolver.consensus import Member
from tests.helpers.data import data_dir
from tests.helpers.solver import synthetic
from tests.helpers.solver.hands import STEADY, Hand

Mode = tuple[str, ...]
BOARD = Board()
PLACES = (
    (0.0, 0.0),
    (-0.35, -0.3),
    (0.35, -0.3),
    (-0.35, 0.3),
    (0.35, 0.3),
    (0.0, -0.2),
    (0.2, 0.0),
    (-0.2, 0.1),
)
"""Where the middle of the board is seen, from the middle of the image, in halves of its size."""


def views(
    camera: Camera,
    rng: np.random.Generator,
    noise: float = 0.2,
    count: int = 6,
    hand: Hand = STEADY,
    board: Board = BOARD,
) -> list[View]:
    """Views as a guided capture ends with: close to all parts of the image, tilted by 35 to 50 degrees.

    A view with fewer than 16 corners is taken again with the board farther away.
    """
    w, h = camera.img_size
    middle = board.outline.mean(axis=0)
    least = min(16, len(board.points))
    options: dict[str, Any] = {"hand": hand, "corners": hand.bend(board, rng), "whole_markers": False}
    out: list[View] = []
    for i in range(count):
        x, y = PLACES[i % len(PLACES)] + rng.uniform(-0.06, 0.06, 2)
        ray = camera.unproject(np.array([[(1 + x) * w / 2, (1 + y) * h / 2]]))[0]
        azimuth = 2.4 * i + rng.uniform(0, 1)  # the golden angle, and some
        tilt = np.radians(rng.uniform(35, 50)) * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        towards = rotation.nearest(np.stack([np.cross([0, 1, 0], ray), [0, 1, 0], ray], axis=1))
        r = towards @ rotation.matrix(tilt)
        width = rng.uniform(0.9, 1.1)
        for _ in range(8):
            depth = board.size[0] * camera.matrix[0, 0] / (width * w)
            t = depth * ray - r @ middle
            focused = hand.refocused(camera, rng)
            view = synthetic.detect(board, focused, rotation.vector(r), t, rng, noise, **options)
            if len(view) >= least:
                out.append(view)
                break
            width *= 0.8
    return out


@cache
def rational_cameras(count: int = 12, seed: int = 0) -> tuple[Camera, ...]:
    """Webcams from wide to narrow whose further coefficients are small, as calibrations of them find."""
    rng = np.random.default_rng(seed)
    cameras: list[Camera] = []
    while len(cameras) < count:
        plain = synthetic.rectilinear_cameras(2 * count, int(rng.integers(1 << 30)))
        for camera in plain:
            k1, k2, p1, p2, _ = camera.distortion
            d = np.array([k1, k2, p1, p2, 0, 0, 0, 0])
            d += np.array([0.15, 0.06, 0, 0, 0.015, 0.15, 0.06, 0.015]) * rng.normal(size=8)
            cameras += seen_all(Camera("rational", camera.matrix, d, camera.img_size))
    return tuple(cameras[i] for i in rng.permutation(len(cameras))[:count])


@cache
def omnidirectional_cameras(count: int = 12, seed: int = 0) -> tuple[Camera, ...]:
    """Cameras of 120 to 190 degrees over the diagonal, xi from 0.8 to 2.2 as wide lenses have it."""
    rng = np.random.default_rng(seed)
    cameras: list[Camera] = []
    while len(cameras) < count:
        d = np.array([rng.uniform(0.8, 2.2), *(np.array([0.08, 0.1, 1e-3, 1e-3]) * rng.normal(size=4))])
        angle = np.radians(rng.uniform(120, 190))
        cameras += seen_all(synthetic.of_diagonal("omnidirectional", d, angle, rng))
    return tuple(cameras)


def seen_all(camera: Camera) -> list[Camera]:
    """The camera, if it has a ray for all of its image and a little beyond; else none."""
    w, h = camera.img_size
    rim = np.array([[x, y] for x in (-20.0, w / 2, w + 20.0) for y in (-20.0, h / 2, h + 20.0)])
    return [camera] if np.isfinite(camera.unproject(rim)).all() else []


def profile_rows() -> list[dict[str, str]]:
    with (data_dir() / "lens_profiles.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def profile_camera(row: dict[str, str]) -> Camera:
    fx, fy, cx, cy = (float(row[name]) for name in ("fx", "fy", "cx", "cy"))
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return Camera(
        "fisheye", matrix, [float(row[f"k{i}"]) for i in (1, 2, 3, 4)], (int(row["w"]), int(row["h"]))
    )


def profiles() -> dict[Mode, list[tuple[Camera, float]]]:
    """Published lens profiles by mode (brand, model, lens, setting, size): camera, and its rms in px."""
    modes: dict[Mode, list[tuple[Camera, float]]] = defaultdict(list)
    for row in profile_rows():
        mode = tuple(row[name] for name in ("brand", "model", "lens", "setting", "w", "h"))
        modes[mode].append((profile_camera(row), float(row["rms"] or "nan")))
    return modes


def member(name: str, camera: Camera, rng: np.random.Generator, **options: Any) -> Member:
    """Calibration of a camera by a contributor of that name; options as of `views`."""
    return Member(name, name, tuple(views(camera, rng, **options)))


def members(cameras: Sequence[tuple[Camera, float]], rng: np.random.Generator) -> list[Member]:
    """One calibration each of cameras, with the noise that the rms px of its own calibration shows."""
    return [member(str(i), camera, rng, noise=rms / np.sqrt(2)) for i, (camera, rms) in enumerate(cameras)]


POPULATIONS = {
    "rectilinear": synthetic.rectilinear_cameras,
    "fisheye": synthetic.fisheye_cameras,
    "rational": rational_cameras,
    "omnidirectional": omnidirectional_cameras,
}


@dataclass(frozen=True)
class Intervals:
    """Results of many captures, each of another camera.

    `ratio` (s,): rms over the image of the projection error / of the predicted one. `z` (s, p): errors of the
    intrinsics / their predicted deviations. `out_of_domain`: captures whose result lacks a ray for some pixel
    that the camera has one for. `failed`: captures without a fit.
    """

    ratio: np.ndarray
    z: np.ndarray
    out_of_domain: int
    failed: int

    @property
    def projection(self) -> float:
        return float(np.sqrt(np.mean(self.ratio**2)))

    @property
    def coverage(self) -> np.ndarray:
        """Share (p,) of the captures whose 95 % interval contains the true parameter."""
        share: np.ndarray = np.mean(np.abs(self.z) < 1.959964, axis=0)
        return share


def measure(model: str, captures: int, count: int = 8) -> Intervals:
    rng = np.random.default_rng(0)
    ratio, z, out_of_domain, failed = [], [], 0, 0
    for camera in POPULATIONS[model](captures):
        try:
            c = fit(views(camera, rng, count=count), camera.img_size, model)
        except CalibrationError:
            failed += 1
            continue
        predicted = c.projection_std().ravel()
        error = synthetic.projection_error(camera, c.camera)
        seen = np.isfinite(predicted) & (error < camera.img_size[0])
        out_of_domain += not seen.all()
        ratio.append(np.sqrt(np.mean(error[seen] ** 2) / np.mean(predicted[seen] ** 2)))
        z.append((c.camera.intrinsics - camera.intrinsics) / np.sqrt(np.diag(c.covariance)))
    return Intervals(np.array(ratio), np.array(z), out_of_domain, failed)
