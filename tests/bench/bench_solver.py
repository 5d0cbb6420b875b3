"""The solver against OpenCV, in the same process and in turn, each with one thread."""

import time
import tracemalloc
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any
from unittest import mock

import cv2
import numpy as np

from calibsolver import Board, CalibrationError, Camera, View, fit, guidance, rotation
from calibsolver.consensus.pooling import Member, pool
from calibsolver.fitting import robust_covariance
from calibsolver.fitting.fit import _Fit
from calibsolver.guidance import overlay
from tests.bench import corners, opencv
from tests.bench.table import Row, least_times, one_thread, p50
from tests.helpers import data
from tests.helpers.solver import populations, synthetic

CAMERA = synthetic.rectilinear_cameras()[5]


def rows() -> Iterator[Row]:
    with one_thread():
        yield from real_corners()
        yield rectilinear(100)
        for model in ("rectilinear", "fisheye", "rational"):
            yield covariance(model, 10)
        yield fisheye("jy_left")
        if data.EXTERNAL is not None:  # its licence keeps the set out of `tests/data`
            yield omnidirectional("mint_isaw")
    yield from many()
    yield pool_of_fifty()
    yield from guide()


def real_corners() -> Iterator[Row]:
    """Median and worst ratio of processor times over the real sets that the model fits."""
    drawn, shaped = {}, {}
    for name in data.available(corners.NAMES):
        views, size = data.corner_views(name)
        try:
            fit(views, size)
        except CalibrationError:
            continue
        peer = partial(cv2.calibrateCamera, *data.float32(views), size, None, None)
        for ratios, board_shape in ((drawn, False), (shaped, True)):
            mine, theirs = least_times(partial(fit, views, size, board_shape=board_shape), peer)
            ratios[name] = mine / theirs
    yield from median_and_worst("fit, rectilinear, real corners", drawn, 0.6, 1.1)
    yield from median_and_worst("the same with the board's shape", shaped, 0.8, 1.4)


def median_and_worst(what: str, ratios: dict[str, float], median: float, worst: float) -> Iterator[Row]:
    note, peer = ", ".join(f"{name} {value:.2f}" for name, value in ratios.items()), "/ cv2.calibrateCamera"
    yield Row(f"{what}, {peer}, median", float(np.median([*ratios.values()])), median, "x", note)
    slowest = max(ratios, key=ratios.__getitem__)
    yield Row(f"{what}, {peer}, worst", ratios[slowest], worst, "x", slowest)


def rectilinear(count: int) -> Row:
    views = spread(Board(), CAMERA, count, np.random.default_rng(1))
    start = np.array([[1000.0, 0, 639.5], [0, 1000.0, 359.5], [0, 0, 1]])
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-9)
    points = data.float32(views)

    def peer() -> float:
        return cv2.calibrateCamera(*points, CAMERA.img_size, start.copy(), None, criteria=criteria)[0]

    what = f"fit, rectilinear, {count} views, / cv2.calibrateCamera"
    return against(what, views, CAMERA.img_size, "rectilinear", peer, 0.7, f"{sum(map(len, views))} corners")


def against(
    what: str,
    views: list[View],
    size: tuple[int, int],
    model: str,
    peer: Callable[[], float],
    budget: float,
    note: str,
    repeat: int = 7,
) -> Row:
    """Row of the least times of a fit, with the board as drawn, and of a peer, which returns its rms."""

    def ours() -> float:
        return fit(views, size, model, board_shape=False).avg_reprojection_error

    mine, theirs = least_times(ours, peer, repeat)
    rms = f"rms {ours():.4f} and {peer():.4f} px" if repeat > 1 else f"rms {ours():.4f} px"
    note = f"{1e3 * mine:.1f} ms against {1e3 * theirs:.1f} ms; {note}; {rms}"
    return Row(what, mine / theirs, budget, "x", note)


def spread(board: Board, camera: Camera, count: int, rng: np.random.Generator) -> list[View]:
    """Views as people take them: all of the board in the picture, tilted by 15 to 45 degrees."""
    views: list[View] = []
    center = board.outline.mean(axis=0)
    while len(views) < count:
        axis = rng.uniform(0, 2 * np.pi)
        rvec = np.radians(rng.uniform(15, 45)) * np.array([np.cos(axis), np.sin(axis), 0])
        depth = board.size[0] * camera.matrix[0, 0] / (rng.uniform(0.4, 0.7) * camera.img_size[0])
        place = np.array([*(rng.uniform(-0.15, 0.15, 2) * depth), depth])
        view = synthetic.detect(board, camera, rvec, place - rotation.matrix(rvec) @ center, rng)
        if len(view) == board.corner_count:
            views.append(view)
    return views


def covariance(model: str, count: int) -> Row:
    """Least processor time of the covariance over that of the whole fit, in the same process."""
    views = spread(Board(), CAMERA, count, np.random.default_rng(1))
    spent = 0.0

    def timed(action: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any) -> Any:
            nonlocal spent
            begun = time.thread_time()
            result = action(*arguments)
            spent += time.thread_time() - begun
            return result

        return run

    parts, wholes = [], []
    with (
        mock.patch.object(_Fit, "_evidence", timed(_Fit._evidence)),
        mock.patch.object(robust_covariance, "estimate", timed(robust_covariance.estimate)),
    ):
        for _ in range(40):
            spent, begun = 0.0, time.thread_time()
            fit(views, CAMERA.img_size, model, board_shape=False)
            wholes.append(time.thread_time() - begun)
            parts.append(spent)
    note = f"{1e6 * min(parts):.0f} us of {1e6 * min(wholes):.0f}"
    what = f"covariance of a fit, {model}, {count} views / the fit"
    return Row(what, min(parts) / min(wholes), 0.05, "x", note)


def fisheye(name: str) -> Row:
    views, size = data.corner_views(name)

    def peer() -> float:
        return opencv.calibrate(views, size, "fisheye")[0]

    return against("fit, fisheye, / cv2.fisheye.calibrate", views, size, "fisheye", peer, 0.2, name)


def omnidirectional(name: str) -> Row:
    """OpenCV's own takes seconds: once."""
    views, size = data.corner_views(name)
    objects = [v.object_points[None] for v in views]
    images = [v.image_points[None] for v in views]
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 500, 1e-12)
    flags = cv2.omnidir.CALIB_FIX_SKEW

    def peer() -> float:
        return cv2.omnidir.calibrate(objects, images, size, None, None, None, flags, criteria)[0]

    what = "fit, omnidirectional, / cv2.omnidir.calibrate"
    return against(what, views, size, "omnidirectional", peer, 0.05, name, repeat=1)


def many() -> Iterator[Row]:
    """Cost by the number of views, and memory, at a thousand of them."""
    views = spread(Board(), CAMERA, 1000, np.random.default_rng(1))
    quarter = p50(lambda: fit(views[:250], CAMERA.img_size, board_shape=False), repeat=7)
    whole = p50(lambda: fit(views, CAMERA.img_size, board_shape=False), repeat=7)
    yield Row("fit, 1000 views / four times 250 views", whole / (4 * quarter), 1.3, "x", f"{whole:.0f} ms")
    tracemalloc.start()
    fit(views, CAMERA.img_size, board_shape=False)
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    yield Row("fit, 1000 views, memory", peak, 200, "MB")


def pool_of_fifty() -> Row:
    rng = np.random.default_rng(0)
    camera = synthetic.rectilinear_cameras()[6]
    members = [Member(f"{i}", f"{i}", tuple(populations.views(camera, rng, count=12))) for i in range(50)]
    start = time.process_time()
    pool(members, camera.img_size, "rectilinear")
    return Row("consensus of 50 calibrations", time.process_time() - start, 10, "s")


def guide() -> Iterator[Row]:
    board = Board()
    views = spread(board, CAMERA, 4, np.random.default_rng(1))
    calibration = fit(views, CAMERA.img_size, board_shape=False)
    chooser = guidance.ProjectionUncertainty(board, CAMERA.img_size)
    target = chooser.next_pose(views, calibration)
    yield Row("next pose, 300 candidates", p50(lambda: chooser.next_pose(views, calibration)), 10, "ms")
    picture = overlay.render(board, calibration.camera, target)
    ms = p50(lambda: overlay.render(board, calibration.camera, target))
    yield Row("overlay JPEG 1280x720", ms, 15, "ms", f"{len(picture) / 1000:.0f} KB")
