"""A fit whose outcome is known."""

import numpy as np

from calibsolver import Board, Camera, View, fit, rotation

_FX, _IMG_SIZE = 950.0, (1280, 720)


def solve() -> None:
    """Fit a known camera to computed views; raises ValueError."""
    matrix = np.array([[_FX, 0.0, 640.0], [0.0, _FX, 360.0], [0.0, 0.0, 1.0]])
    camera = Camera("rectilinear", matrix, np.zeros(5), _IMG_SIZE)
    points = Board().points
    views = []
    for turn in ((0.5, 0.0, 0.0), (-0.4, 0.3, 0.1), (0.1, 0.5, 0.0), (0.0, -0.5, 0.2)):
        placed = points @ rotation.matrix(np.array(turn)).T + np.array([-4.5, -3.0, 10.0])
        views.append(View(points, camera.project(placed)))
    focal = fit(views, _IMG_SIZE).camera.matrix[0, 0]
    if not abs(focal / _FX - 1) < 1e-3:
        raise ValueError(f"fx is {focal} px, not {_FX} px")
