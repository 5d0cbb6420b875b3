"""Calibrations to export: one camera of every model, calibrated from views with a little noise."""

from functools import cache

import numpy as np

from calibsolver import Board, Camera, View, fit, rotation
from calibsolver.arrays import Array
from calibsolver.formats import ExportedFile, ExportSource, write

IMG_SIZE = (1280, 720)
TRUTH = {
    "rectilinear": (900.0, [-0.2, 0.05, 0.001, -0.0005, 0.01]),
    "rational": (800.0, [0.5, -0.1, 0.0004, -0.0006, 0.01, 0.8, -0.05, 0.02]),
    "fisheye": (420.0, [0.02, -0.01, 0.003, -0.001]),
    "omnidirectional": (900.0, [1.2, -0.1, 0.02, 0.0005, -0.0005]),
}


def truth(model: str) -> Camera:
    f, d = TRUTH[model]
    return Camera(model, np.array([[f, 0, 650], [0, f * 1.002, 350], [0, 0, 1]]), np.array(d), IMG_SIZE)


@cache
def subject(model: str) -> ExportSource:
    board = Board()
    views = captured(truth(model), board)
    calibration = fit(views, IMG_SIZE, model=model)
    return ExportSource(
        camera=calibration.camera,
        views=views,
        board=board,
        name="Acme “HD” cam: 4K & more",
        identifier="calibration-1",
        rms=calibration.avg_reprojection_error,
        time=1_700_000_000,
        record={"id": "calibration-1", "reliable": False},
    )


@cache
def written(model: str, name: str) -> ExportedFile:
    return write(subject(model), name)


def captured(camera: Camera, board: Board, count: int = 10, noise: float = 0.1) -> tuple[View, ...]:
    """Views of a board held before different parts of the image, a part of it unseen in some."""
    rng = np.random.default_rng(5)
    (w, h), views = camera.img_size, []
    while len(views) < count:
        ray = camera.unproject(np.array([[rng.uniform(0.2, 0.8) * w, rng.uniform(0.2, 0.8) * h]]))[0]
        side = np.cross([0.0, 1.0, 0.0], ray) / np.linalg.norm(np.cross([0.0, 1.0, 0.0], ray))
        frame = np.stack([side, np.cross(ray, side), ray], axis=1)
        r = frame @ rotation.matrix(rng.uniform(-0.6, 0.6, (1, 3)) * (1, 1, 0.5))[0]
        p = (board.points - (4.5, 3, 0)) @ r.T + ray * rng.uniform(5, 9)
        q = camera.project(p)
        ids = np.flatnonzero(camera.valid(p) & (q > 0).all(axis=1) & (q < np.array([w, h]) - 1).all(axis=1))
        if len(ids) > 20:
            views.append(board.view(ids.tolist(), q[ids] + noise * rng.normal(size=(len(ids), 2))))
    return tuple(views)


def image_rays(camera: Camera, columns: int = 17, rows: int = 11, border: float = 0.0) -> tuple[Array, Array]:
    """Rays (n, 3) and pixels (n, 2) of a grid over the image, from `border` px outside the outer pixels."""
    w, h = camera.img_size
    x, y = np.meshgrid(
        np.linspace(-border, w - 1 + border, columns), np.linspace(-border, h - 1 + border, rows)
    )
    q = np.stack([x.ravel(), y.ravel()], axis=1)
    rays = camera.unproject(q)
    seen = np.isfinite(rays).all(axis=1)
    return rays[seen], q[seen]
