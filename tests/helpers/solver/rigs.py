"""Rigs: synthetic ones, cameras of known intrinsics and poses, and the real pair of OpenCV's samples."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibsolver import Board, Camera, View, rotation
from calibsolver.arrays import Array
from calibsolver.camera import pixel_grid
from calibsolver.rig.start import RigidMotion, symmetries, turn_back
from tests.helpers.data import corner_set

REAL_SIZE = (640, 480)
REVERSED = (8, 1)
"""Moment and position of the real view whose corners are numbered from the other end: right09."""
MIN_SEEN = 12
"""Corners of a view, at least."""
MAX_DRAWS = 2000
"""Boards that are held at random for one moment, at most."""


@dataclass(frozen=True, eq=False)
class Rig:
    """Cameras and their motions, camera 0 -> camera i, board units."""

    cameras: Sequence[Camera]
    motions: Sequence[RigidMotion]

    def see(self, board: Board, pose: RigidMotion, noise: float, rng: np.random.Generator) -> dict[int, View]:
        """Views of a board at `pose`, board -> camera 0, of the cameras that see enough of it."""
        moment = {}
        for i, (camera, motion) in enumerate(zip(self.cameras, self.motions, strict=True)):
            there = motion @ pose
            p = there(board.points)
            if there.r[:, 2] @ p.mean(axis=0) <= 0:
                continue  # from behind
            seen = project(camera, p)
            w, h = camera.img_size
            inside = ((seen > 2) & (seen < (w - 3, h - 3))).all(axis=1)
            if inside.sum() >= MIN_SEEN:
                ids = np.flatnonzero(inside)
                moment[i] = board.view(ids, seen[ids] + rng.normal(0, noise, (len(ids), 2)))
        return moment


def project(camera: Camera, points: Array) -> Array:
    """Pixels (n, 2) of points (n, 3); -1 where they are not in front."""
    return np.nan_to_num(camera.project(points), nan=-1.0, posinf=-1.0, neginf=-1.0)


def placed(centre: Sequence[float], turn: Sequence[float]) -> RigidMotion:
    """Motion camera 0 -> a camera with this centre, turned by a rotation vector, both in camera 0's frame."""
    r = rotation.matrix(np.asarray(turn, dtype=np.float64)).T
    return RigidMotion(r, -r @ np.asarray(centre, dtype=np.float64))


def side_by_side(cameras: Sequence[Camera], baseline: float) -> Rig:
    """Rig of cameras on a line, `baseline` board units apart, each turned a little."""
    motions = [
        placed((i * baseline, 0.02 * i, 0), (0.01 * i, -0.02 * i, 0.005 * i)) for i in range(len(cameras))
    ]
    return Rig(cameras, motions)


def ring(cameras: Sequence[Camera], radius: float) -> Rig:
    step = 2 * np.pi / len(cameras)
    motions = [
        placed((radius * np.sin(i * step), 0, radius * (np.cos(i * step) - 1)), (0, i * step, 0))
        for i in range(len(cameras))
    ]
    return Rig(cameras, motions)


def moments(
    rig: Rig, board: Board, count: int, noise: float, rng: np.random.Generator, shared: int = 2
) -> list[dict[int, View]]:
    """Moments of boards held at random before each camera in turn, seen by `shared` cameras at least."""
    found: list[dict[int, View]] = []
    middle = board.points.mean(axis=0)
    for _ in range(MAX_DRAWS * count):
        which = len(found) % len(rig.cameras)
        camera = rig.cameras[which]
        w, h = camera.img_size
        pixel = rng.uniform((0.1 * w, 0.15 * h), (0.9 * w, 0.85 * h))
        ray = camera.unproject(pixel[None])[0]
        distance = rng.uniform(0.8, 1.6) * board.size[0] * camera.focal[0] / w
        tilt = rotation.matrix(np.append(rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.3, 0.3)))
        r = rotation.rotation_to_ray(ray[None])[0] @ tilt
        before = RigidMotion(r, distance * ray - r @ middle)
        moment = rig.see(board, rig.motions[which].inverse() @ before, noise, rng)
        if len(moment) >= shared:
            found.append(moment)
        if len(found) == count:
            return found
    raise ValueError("the cameras look in different directions")


def transfer_error(truth: Rig, found: Rig, distances: Sequence[float]) -> float:
    """Rms distance, px, of points of one camera in another from where `found` has them, over ordered pairs.

    The points are pixels on a grid that land in the other image, at a distance along the ray.
    """
    squares = []
    for i, one in enumerate(found.cameras):
        pixels = pixel_grid(one.img_size, (12, 9)).reshape(2, -1).T
        for j, other in enumerate(found.cameras):
            if i == j:
                continue
            seen = [
                rig.cameras[j].project(
                    (rig.motions[j] @ rig.motions[i].inverse())(
                        distances[i] * rig.cameras[i].unproject(pixels)
                    )
                )
                for rig in (truth, found)
            ]
            size = np.asarray(other.img_size) - 1
            inside = ((seen[1] > 0) & (seen[1] < size)).all(axis=1) & np.isfinite(seen[0]).all(axis=1)
            if inside.sum() >= 3:
                squares.append(((seen[0] - seen[1])[inside] ** 2).sum(axis=1))
    return float(np.sqrt(np.concatenate(squares).mean()))


def late_moment(
    rig: Rig, board: Board, shift: float, noise: float, rng: np.random.Generator
) -> dict[int, View]:
    """Views of cameras 0 and 1, the board moved by `shift` board units between them."""
    camera, middle = rig.cameras[0], board.points.mean(axis=0)
    for _ in range(MAX_DRAWS):
        r = rotation.matrix(rng.uniform(-0.5, 0.5, 3))
        depth = rng.uniform(0.9, 1.6) * board.size[0] * camera.focal[0] / camera.img_size[0]
        place = np.array([rng.uniform(-0.3, 0.3), rng.uniform(-0.2, 0.2), 1.0]) * depth - r @ middle
        direction = rng.normal(size=3)
        moved = place + shift * direction / np.linalg.norm(direction)
        first = rig.see(board, RigidMotion(r, place), noise, rng)
        second = rig.see(board, RigidMotion(r, moved), noise, rng)
        if 0 in first and 1 in second:
            return {0: first[0], 1: second[1]}
    raise ValueError("the cameras look in different directions")


def real_pairs() -> list[dict[int, View]]:
    """Moments of the stereo pair that OpenCV's samples show; pair 09 is numbered from both ends."""
    sides = [
        {view["file"][-6:-4]: View(view["obj"], view["img"]) for view in corner_set(name)["views"]}
        for name in ("opencv_left", "opencv_right")
    ]
    numbers = sorted(set(sides[0]) & set(sides[1]))
    return [{i: side[number] for i, side in enumerate(sides)} for number in numbers]


def corrected_pairs() -> list[dict[int, View]]:
    """Pairs whose reversed view is turned back, points in one order on both sides, as OpenCV wants them."""
    moments = real_pairs()
    m, position = REVERSED
    moments[m][position] = turn_back(moments[m][position], symmetries([moments[m][0]])[1])
    for i, view in moments[m].items():
        order = np.lexsort(np.round(view.object_points).T)
        moments[m][i] = View(view.object_points[order], view.image_points[order])
    return moments
