"""Rigs: joint fits of two cameras against OpenCV's, in one process and in turn, each with one thread."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from calibsolver import Board, View, rig
from calibsolver.rig.start import RigidMotion
from calibsolver.rotation import matrix
from tests.bench.table import Row, least_times, p50
from tests.helpers.solver import rigs, synthetic

REAL_BUDGET, SIMULATED_BUDGET = 0.85, 0.3
SIMULATED_COUNT = 40


def rows() -> Iterator[Row]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield stereo("13 real pairs", rigs.mended_pairs(), rigs.REAL_SIZE, REAL_BUDGET)
        camera = synthetic.rectilinear_cameras()[5]
        yield stereo(
            f"{SIMULATED_COUNT} simulated pairs",
            whole_boards(SIMULATED_COUNT),
            camera.img_size,
            SIMULATED_BUDGET,
        )
        yield next_moment()
    finally:
        cv2.setNumThreads(threads)


def stereo(what: str, moments: Sequence[dict[int, View]], size: tuple[int, int], budget: float) -> Row:
    """Time of a fit with everything free; both cameras have the same points, in the same order."""
    points = [moment[0].object_points.astype(np.float32) for moment in moments]
    pixels = [[moment[i].image_points.astype(np.float32) for moment in moments] for i in (0, 1)]

    def ours() -> rig.RigCalibration:
        return rig.fit(moments, [(size, "rectilinear")] * 2)

    def peer() -> float:
        return cv2.stereoCalibrate(points, *pixels, None, None, None, None, size, flags=0)[0]

    mine, theirs = least_times(ours, peer)
    note = f"{1e3 * mine:.0f} ms against {1e3 * theirs:.0f} ms; rms {ours().rms:.4f} and {peer():.4f} px"
    return Row(f"rig of two, {what}, / cv2.stereoCalibrate", mine / theirs, budget, "x", note)


def whole_boards(count: int) -> list[dict[int, View]]:
    """Moments in which both cameras see all corners."""
    board, rng = Board(), np.random.default_rng(1)
    camera = synthetic.rectilinear_cameras()[5]
    truth = rigs.side_by_side([camera, camera], 1.0)
    middle = board.points.mean(axis=0)
    found: list[dict[int, View]] = []
    while len(found) < count:
        r = matrix(np.append(rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.3, 0.3)))
        depth = rng.uniform(1.3, 2.2) * board.size[0] * camera.focal[0] / camera.img_size[0]
        place = np.array([*(rng.uniform(-0.15, 0.15, 2) * depth), depth])
        moment = truth.see(board, RigidMotion(r, place - r @ middle), 0.2, rng)
        if len(moment) == 2 and all(len(view) == board.corner_count for view in moment.values()):
            found.append(moment)
    return found


def next_moment() -> Row:
    """Time in which the next moment of a rig of two is chosen."""
    camera = synthetic.rectilinear_cameras()[5]
    cameras = [(camera.img_size, "rectilinear")] * 2
    moments = whole_boards(5)
    found = rig.fit(moments, cameras)
    ms = p50(lambda: rig.next_moment(Board(), cameras, moments, found), repeat=10)
    return Row("next moment of a rig of two", ms, None, "ms")
