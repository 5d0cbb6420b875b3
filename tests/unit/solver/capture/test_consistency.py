"""Consistency of views: one that another camera took is found among those of the camera."""

import numpy as np
import pytest

from calibsolver import Board, Camera, View, rotation
from calibsolver.capture.consistency import Consistency
from tests.helpers.solver import synthetic

BOARD = Board()
CAMERA = synthetic.rectilinear_cameras()[6]
OTHER = Camera(
    "rectilinear",
    np.array([[700.0, 0, 640], [0, 700, 360], [0, 0, 1]]),
    np.array([-0.05, 0, 0, 0, 0]),
    CAMERA.img_size,
)


# Rotation vectors, and places of the board's middle, in squares
POSES = [
    ((0.5, 0.0, 0.0), (0, 0, 11)),
    ((-0.5, 0.1, 0.1), (3, 1, 12)),
    ((0.0, 0.6, 0.0), (-3, 1, 12)),
    ((0.1, -0.6, 0.2), (2, -1, 13)),
    ((0.4, 0.4, 1.5), (-2, -1, 12)),
    ((-0.3, -0.4, 0.0), (0, 1, 14)),
]


def view_of(camera: Camera, index: int) -> View:
    """The board in the pose of that number, before a camera."""
    turn, middle = POSES[index]
    rvec = np.array(turn)
    tvec = np.array(middle) - rotation.matrix(rvec) @ (4.5, 3, 0)
    return synthetic.detect(BOARD, camera, rvec, tvec, np.random.default_rng(index))


@pytest.mark.parametrize("place", [0, 1])
def test_view_of_another_camera_is_an_outlier_and_conflicts_with_the_next_view(place: int) -> None:
    views = [view_of(CAMERA, index) for index in range(len(POSES))]
    consistency = Consistency(CAMERA.img_size, "rectilinear")
    assert consistency.find_outlier_view(views) is None
    assert consistency.find_conflicting_view(views[:4], views[5]) is None
    views[place] = view_of(OTHER, place)
    assert consistency.find_outlier_view(views) == place
    assert consistency.find_conflicting_view(views[:4], views[5]) == place
