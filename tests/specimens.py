"""Calibrations as they might come from many people: views of made-up and of published cameras."""

import csv
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from calibsolver import Board, Camera, View, rotation
from calibsolver.consensus import Member
from tests import synthetic
from tests.data import data_dir

Mode = tuple[str, ...]
BOARD = Board()
PLACES = (
    (0.0, 0.0),
    (-0.5, -0.45),
    (0.5, -0.45),
    (-0.5, 0.45),
    (0.5, 0.45),
    (0.0, -0.3),
    (0.3, 0.0),
    (-0.3, 0.1),
)
"""Where the middle of the board is seen, from the middle of the image, in halves of its size."""


def views(camera: Camera, rng: np.random.Generator, noise: float = 0.2, count: int = 8) -> list[View]:
    """Views of a good capture: the board in all parts of the image, tilted by 20 to 40 degrees.

    A view that shows fewer than 16 corners is taken again with the board farther away.
    """
    w, h = camera.img_size
    middle = BOARD.outline.mean(axis=0)
    out: list[View] = []
    for i in range(count):
        x, y = PLACES[i % len(PLACES)] + rng.uniform(-0.08, 0.08, 2)
        ray = camera.unproject(np.array([[(1 + x) * w / 2, (1 + y) * h / 2]]))[0]
        azimuth = 2.4 * i + rng.uniform(0, 1)  # the golden angle, and some
        tilt = np.radians(rng.uniform(20, 40)) * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        towards = rotation.nearest(np.stack([np.cross([0, 1, 0], ray), [0, 1, 0], ray], axis=1))
        r = towards @ rotation.matrix(tilt)
        width = rng.uniform(0.5, 0.65)
        for _ in range(8):
            depth = BOARD.size[0] * camera.matrix[0, 0] / (width * w)
            t = depth * ray - r @ middle
            view = synthetic.seen(BOARD, camera, rotation.vector(r), t, rng, noise)
            if len(view) >= 16:
                out.append(view)
                break
            width *= 0.8
    return out


def profiles() -> dict[Mode, list[tuple[Camera, float]]]:
    """Published lens profiles by mode (brand, model, lens, setting, size): camera, and its rms in px."""
    modes: dict[Mode, list[tuple[Camera, float]]] = defaultdict(list)
    with (data_dir() / "lens_profiles.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            size = (int(row["w"]), int(row["h"]))
            fx, fy, cx, cy = (float(row[name]) for name in ("fx", "fy", "cx", "cy"))
            matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
            camera = Camera("fisheye", matrix, [float(row[f"k{i}"]) for i in (1, 2, 3, 4)], size)
            mode = tuple(row[name] for name in ("brand", "model", "lens", "setting", "w", "h"))
            modes[mode].append((camera, float(row["rms"] or "nan")))
    return modes


def members(cameras: Sequence[tuple[Camera, float]], rng: np.random.Generator) -> list[Member]:
    """One calibration each of cameras, with the noise that the rms px of its own calibration shows."""
    return [
        Member(str(i), str(i), tuple(views(camera, rng, rms / np.sqrt(2))))
        for i, (camera, rms) in enumerate(cameras)
    ]
