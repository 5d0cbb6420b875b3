"""Rigs: joint fits of two cameras against OpenCV's, in one process and in turn, each with one thread."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from calibsolver import Board, View, rig
from calibsolver.rig.start import RigidMotion
from calibsolver.rotation import matrix
from tests.bench.table import Row, least_times, one_thread, p50
from tests.helpers.data import float32
from tests.helpers.solver import rigs, synthetic

REAL_BUDGET, SIMULATED_BUDGET = 0.85, 0.3
SIMULATED_COUNT = 40
CAMERA = synthetic.rectilinear_cameras()[5]


def rows() -> Iterator[Row]:
    with one_thread():
        yield stereo("13 real pairs", rigs.corrected_pairs(), rigs.REAL_SIZE, REAL_BUDGET)
        simulated = whole_boards(SIMULATED_COUNT)
        yield stereo(f"{SIMULATED_COUNT} simulated pairs", simulated, CAMERA.img_size, SIMULATED_BUDGET)
        yield next_moment()


def stereo(what: str, moments: Sequence[dict[int, View]], size: tuple[int, int], budget: float) -> Row:
    """Time of a fit with everything free; both cameras have the same points, in the same order."""
    (points, left), (_, right) = (float32([moment[i] for moment in moments]) for i in (0, 1))

    def ours() -> rig.RigCalibration:
        return rig.fit(moments, [(size, "rectilinear")] * 2)

    def peer() -> float:
        return cv2.stereoCalibrate(points, left, right, None, None, None, None, size, flags=0)[0]

    mine, theirs = least_times(ours, peer)
    note = f"{1e3 * mine:.0f} ms against {1e3 * theirs:.0f} ms; rms {ours().rms:.4f} and {peer():.4f} px"
    return Row(f"rig of two, {what}, / cv2.stereoCalibrate", mine / theirs, budget, "x", note)


def whole_boards(count: int) -> list[dict[int, View]]:
    """Moments in which both cameras see all corners."""
    board, rng = Board(), np.random.default_rng(1)
    truth = rigs.side_by_side([CAMERA, CAMERA], 1.0)
    middle = board.points.mean(axis=0)
    found: list[dict[int, View]] = []
    while len(found) < count:
        r = matrix(np.append(rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.3, 0.3)))
        depth = rng.uniform(1.3, 2.2) * board.size[0] * CAMERA.focal[0] / CAMERA.img_size[0]
        place = np.array([*(rng.uniform(-0.15, 0.15, 2) * depth), depth])
        moment = truth.see(board, RigidMotion(r, place - r @ middle), 0.2, rng)
        if len(moment) == 2 and all(len(view) == board.corner_count for view in moment.values()):
            found.append(moment)
    return found


def next_moment() -> Row:
    cameras = [(CAMERA.img_size, "rectilinear")] * 2
    moments = whole_boards(5)
    found = rig.fit(moments, cameras)
    ms = p50(lambda: rig.next_moment(Board(), cameras, moments, found), repeat=10)
    return Row("next moment of a rig of two", ms, None, "ms")
