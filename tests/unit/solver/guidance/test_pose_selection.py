"""Pose selection: the method behaves as published, for every model."""

import numpy as np
import pytest

from calibsolver import Board, Camera, models
from calibsolver.guidance import PoseSelection
from calibsolver.guidance.overlap import jaccard_index
from calibsolver.guidance.pose_selection import Box, displacement, find_next_region, subdivided_tilt_deg
from tests.helpers.solver import peers, synthetic

SIZE = (1280, 720)


def test_angles_are_subdivided() -> None:
    assert [subdivided_tilt_deg(n) for n in range(4)] == [-35.0, 35.0, -52.5, 52.5]


def test_first_pose_is_the_published_one() -> None:
    first = PoseSelection(Board(), SIZE).next_pose([], None)
    assert np.degrees(np.linalg.norm(first.rvec)) == pytest.approx(50.0, abs=1)
    assert len(first.ids) == 40


@pytest.mark.parametrize("model", models.NAMES)
def test_second_pose_fills_the_picture_for_every_model(model: str) -> None:
    """As far as the board's shape allows: 0.84 of the width where nothing is distorted."""
    camera = synthetic.rectilinear_cameras()[6]
    guide = PoseSelection(Board(), SIZE, model)
    first = guide.next_pose([], None)
    view = synthetic.detect(Board(), camera, first.rvec, first.tvec, np.random.default_rng(0))
    target = guide.next_pose([view], None)
    assert target.purpose == "to fill the picture"
    np.testing.assert_allclose(target.rvec, 0, atol=0.01)
    assert 0.75 <= np.ptp(target.outline[:, 0]) / SIZE[0] <= 0.9


@pytest.mark.parametrize("model", models.NAMES)
def test_principal_point_target_is_shifted_by_five_percent(model: str) -> None:
    """Each camera with its own focal length, px per radian at the axis."""
    camera = Camera.from_intrinsics(model, models.get(model).start(900.0, SIZE), SIZE)
    target = PoseSelection(Board(), SIZE, model).tilted_target(2, 0, camera)
    center = target.r @ Board().outline.mean(axis=0) + target.tvec
    shift = camera.project(center[None])[0] - camera.intrinsics[2:4]
    np.testing.assert_allclose(shift, [0.05 * SIZE[0], 0], atol=1)


@pytest.mark.parametrize("model", models.NAMES)
def test_distortion_vanishes_at_the_axis_of_every_model(model: str) -> None:
    """Against a pinhole of the camera's focal length: 0 at the axis, below 1 % of the radius around it."""
    camera = Camera.from_intrinsics(model, models.get(model).start(900.0, SIZE), SIZE)
    field = displacement(camera, SIZE[0] // 20, SIZE[1] // 20)
    x, y = np.meshgrid(np.arange(64) * 20 + 9.5, np.arange(36) * 20 + 9.5)
    radius = np.hypot(x - camera.matrix[0, 2], y - camera.matrix[1, 2])
    near = radius < 100
    assert (field[near] < 0.01 * radius[near]).all()


def test_most_distorted_region_comes_first_and_once() -> None:
    matrix = np.array([[900, 0, 500], [0, 900, 359.5], [0, 0, 1.0]])
    camera = Camera("rectilinear", matrix, np.array([-0.3, 0.1, 0, 0, 0]), SIZE)
    box = find_next_region(camera, [])
    assert box.left > 0.6  # the far side
    assert box.width >= 0.3
    other = find_next_region(camera, [box])
    assert other != box
    assert find_next_region(camera, [Box(0, 0, 1, 1)]) == Box(0.0, 0.0, 1.0, 1.0)


def test_jaccard_index_of_shifted_squares() -> None:
    square = np.array([[100, 100], [500, 100], [500, 500], [100, 500]], dtype=float)
    assert jaccard_index(square, square, SIZE) == 1
    assert jaccard_index(square, np.add(square, (200, 0)), SIZE) == pytest.approx(1 / 3, abs=0.02)
    assert jaccard_index(square, np.add(square, (600, 0)), SIZE) == 0


def test_published_method_stops_after_seven_to_twelve_views() -> None:
    """Published: 9 views, 0.40 px; here two cameras at 0.2 px."""
    sessions = [
        peers.run_published_method(camera, np.random.default_rng(i))
        for i, camera in enumerate(synthetic.rectilinear_cameras()[::6])
    ]
    stops = [session.stopped for session in sessions]
    assert None not in stops
    assert 7 <= np.median(np.array(stops, dtype=float)) <= 12
    assert 0.2 <= np.median([session.mean[-1] for session in sessions]) <= 0.8
