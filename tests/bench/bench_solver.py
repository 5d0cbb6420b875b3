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
from calibsolver.capture import Capture
from calibsolver.consensus.pooling import Member, pool
from calibsolver.fitting import robust_covariance
from calibsolver.fitting.fit import _Fit
from calibsolver.guidance import overlay
from tests.bench import corners
from tests.bench.table import Row, least_times, p50, ratio
from tests.helpers import data
from tests.helpers.solver import populations, synthetic


def rows() -> Iterator[Row]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield from real_corners()
        yield rectilinear(100, 0.7)
        for model in ("rectilinear", "fisheye", "rational"):
            yield covariance(model, 10)
        yield fisheye("jy_left")
        if data.EXTERNAL is not None:  # its licence keeps the set out of `tests/data`
            yield omnidirectional("mint_isaw")
        yield from many()
        yield pool_of_fifty()
        yield from guide()
        yield from convergence()
    finally:
        cv2.setNumThreads(threads)


def real_corners() -> Iterator[Row]:
    """Median and worst ratio of processor times over the real sets that the model fits."""
    drawn, shaped = {}, {}
    for name in data.available(corners.NAMES):
        views, size = data.corner_views(name)
        objects, images = data.float32(views)
        try:
            fit(views, size)
        except CalibrationError:
            continue
        peer = partial(cv2.calibrateCamera, objects, images, size, None, None)
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


def rectilinear(count: int, budget: float) -> Row:
    board = Board()
    camera = synthetic.rectilinear_cameras()[5]
    views = spread(board, camera, count, np.random.default_rng(1))
    objects, images = data.float32(views)
    start = np.array([[1000.0, 0, 639.5], [0, 1000.0, 359.5], [0, 0, 1]])
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-9)

    def peer() -> float:
        return cv2.calibrateCamera(objects, images, camera.img_size, start.copy(), None, criteria=criteria)[0]

    ours = fit(views, camera.img_size, board_shape=False)
    r, a, b = ratio(lambda: fit(views, camera.img_size, board_shape=False), peer)
    count = sum(len(v) for v in views)
    rms = f"rms {ours.avg_reprojection_error:.4f} and {peer():.4f} px"
    note = f"{a:.1f} ms against {b:.1f} ms; {count} corners; {rms}"
    return Row(f"fit, rectilinear, {len(views)} views, / cv2.calibrateCamera", r, budget, "x", note)


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
    board = Board()
    camera = synthetic.rectilinear_cameras()[5]
    views = spread(board, camera, count, np.random.default_rng(1))
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
            fit(views, camera.img_size, model, board_shape=False)
            wholes.append(time.thread_time() - begun)
            parts.append(spent)
    note = f"{1e6 * min(parts):.0f} us of {1e6 * min(wholes):.0f}"
    what = f"covariance of a fit, {model}, {count} views / the fit"
    return Row(what, min(parts) / min(wholes), 0.05, "x", note)


def fisheye(name: str) -> Row:
    views, img_size = data.corner_views(name)
    objects = [v.object_points[None] for v in views]
    images = [v.image_points[None] for v in views]
    flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW

    def peer() -> float:
        k, d = np.eye(3), np.zeros((4, 1))
        return cv2.fisheye.calibrate(objects, images, img_size, k, d, flags=flags)[0]

    ours = fit(views, img_size, "fisheye", board_shape=False)
    r, a, b = ratio(lambda: fit(views, img_size, "fisheye", board_shape=False), peer, repeat=5)
    note = f"{a:.0f} ms against {b:.0f} ms; {name}; rms {ours.avg_reprojection_error:.4f} and {peer():.4f} px"
    return Row("fit, fisheye, / cv2.fisheye.calibrate", r, 0.2, "x", note)


def omnidirectional(name: str) -> Row:
    """OpenCV's own takes many seconds to its optimum: once, and not warmed up."""
    views, img_size = data.corner_views(name)
    objects = [v.object_points[None] for v in views]
    images = [v.image_points[None] for v in views]
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 500, 1e-12)
    flags = cv2.omnidir.CALIB_FIX_SKEW
    begun = time.perf_counter()
    rms = cv2.omnidir.calibrate(objects, images, img_size, None, None, None, flags, criteria)[0]
    theirs = 1e3 * (time.perf_counter() - begun)
    mine = p50(lambda: fit(views, img_size, "omnidirectional", board_shape=False), repeat=7)
    ours = fit(views, img_size, "omnidirectional", board_shape=False).avg_reprojection_error
    note = f"{mine:.0f} ms against {theirs:.0f} ms; {name}; rms {ours:.4f} and {rms:.4f} px"
    return Row("fit, omnidirectional, / cv2.omnidir.calibrate", mine / theirs, 0.05, "x", note)


def many() -> Iterator[Row]:
    """Cost by the number of views, and memory, at a thousand of them."""
    camera = synthetic.rectilinear_cameras()[5]
    views = spread(Board(), camera, 1000, np.random.default_rng(1))
    quarter = p50(lambda: fit(views[:250], camera.img_size, board_shape=False), repeat=7)
    whole = p50(lambda: fit(views, camera.img_size, board_shape=False), repeat=7)
    yield Row("fit, 1000 views / four times 250 views", whole / (4 * quarter), 1.3, "x", f"{whole:.0f} ms")
    tracemalloc.start()
    fit(views, camera.img_size, board_shape=False)
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    yield Row("fit, 1000 views, memory", peak, 200, "MB")


def pool_of_fifty() -> Row:
    """CPU time of a consensus of 50 calibrations, each of twelve views."""
    rng = np.random.default_rng(0)
    camera = synthetic.rectilinear_cameras()[6]
    members = [Member(f"{i}", f"{i}", tuple(populations.views(camera, rng, count=12))) for i in range(50)]
    start = time.process_time()
    pool(members, camera.img_size, "rectilinear")
    return Row("consensus of 50 calibrations", time.process_time() - start, 10, "s")


def guide() -> Iterator[Row]:
    board = Board()
    camera = synthetic.rectilinear_cameras()[5]
    views: list[View] = spread(board, camera, 4, np.random.default_rng(1))
    calibration = fit(views, camera.img_size, board_shape=False)
    chooser = guidance.ProjectionUncertainty(board, camera.img_size)
    target = chooser.next_pose(views, calibration)
    ms = p50(lambda: chooser.next_pose(views, calibration))
    yield Row("next pose, 300 candidates", ms, 10, "ms")
    picture = overlay.render(board, calibration.camera, target)
    ms = p50(lambda: overlay.render(board, calibration.camera, target))
    yield Row("overlay JPEG 1280x720", ms, 15, "ms", f"{len(picture) / 1000:.0f} KB")


def convergence() -> Iterator[Row]:
    """The closed loop of 12 cameras x 3 seeds; the published method's 9 views end at 0.40 px (median)."""
    published = 0.40
    rng = np.random.default_rng(0)
    board = Board()
    runs = []
    for camera in synthetic.rectilinear_cameras():
        for _ in range(3):
            capture = Capture(board, camera.img_size)
            runs.append(synthetic.run(camera, rng, board=board, views=5, capture=capture))
    mean = np.median([run.mean for run in runs], axis=0)
    needed = int(np.argmax(mean <= published)) + 1
    medians = ", ".join(f"{value:.2f}" for value in mean)
    yield Row("views to 0.40 px, the published 9-view accuracy", needed, 3, "views", f"medians {medians} px")
    stopped = [run.stopped or 6 for run in runs]
    yield Row("views until the capture ends (median)", float(np.median(stopped)), None, "views")
