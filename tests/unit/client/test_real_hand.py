"""Captures in pictures end in time, with an error that is stated, whatever the hand does."""

import cv2
import numpy as np
import pytest

from calibdb_client import Board, CameraKey, Recording, offline
from calibdb_client.capture import guide as guide_module
from calibdb_client.capture.feedback import Scene
from calibdb_client.detection import Corners
from calibdb_client.recording import RecordedView
from calibsolver import Camera, rotation
from tests.helpers.board_pictures import TILTS
from tests.helpers.real_hand import RealCamera
from tests.helpers.solver import synthetic
from tests.helpers.virtual_person import Listener, VirtualCamera

MAX_CAPTURE_S = 90.0
MAX_ERROR_RATIO = 2.0
THOROUGH = tuple(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(12))


@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("seed", THOROUGH)
def test_capture_at_and_off_the_outline_ends_within_90_s(seed: int, follows: bool) -> None:
    capture(RealCamera(seed=seed, follows=follows))


@pytest.mark.thorough
def test_capture_of_a_flat_board_ends_within_90_s_and_within_twice_its_stated_error() -> None:
    error, stated = capture(RealCamera(size=(480, 360), fx=430, bend_mm=0))
    assert error < MAX_ERROR_RATIO * stated


def capture(camera: RealCamera) -> tuple[float, float]:
    """Capture, and return the error over the image and the stated one, px."""
    result = offline.calibrate(camera, board=Board(), show=camera, clock=camera.clock)
    assert 4 <= result.used <= 15
    assert camera.clock() < MAX_CAPTURE_S
    assert result.verdict[0] in ("good", "fair", "poor")
    stated = result.calibration.record["uncertainty"]
    assert stated["inside"] < stated["rms"]
    assert 0.3 < stated["covered"] < 1
    truth = Camera("rectilinear", camera.matrix, camera.distortion, camera.size)
    return synthetic.rms_error(truth, Camera.from_record(result.calibration.record)), stated["rms"]


@pytest.mark.usefixtures("no_suggestion")
def test_capture_without_another_view_for_30_s_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three views are of an earlier capture, one is taken."""
    monkeypatch.setattr(guide_module, "TARGET_ERROR_WIDTHS", 1e-9)
    camera, earlier = VirtualCamera(size=(480, 360), fx=430, seed=2), []
    for n, tilt in enumerate(np.array(TILTS[:3])):
        place = np.array([0, 0, 11]) - rotation.matrix(tilt) @ camera.middle
        points = cv2.projectPoints(camera.board.points, tilt, place, camera.matrix, camera.distortion)[0][
            :, 0
        ]
        points += camera.rng.normal(0, 0.1, points.shape)
        earlier.append(RecordedView.of(f"{n}", Corners(tuple(range(len(points))), points)))
    begun = Recording(CameraKey("Camera", "linux", camera.size), camera.board, tuple(earlier))
    listener = Listener(camera)
    taken_at: list[float] = []

    def follow(scene: Scene) -> str:
        camera.words = "" if taken_at else scene.instruction
        camera.frames += 20 if taken_at else 0  # none of which shows anything new
        return ""

    monkeypatch.setattr(listener, "show", follow)
    monkeypatch.setattr(listener, "taken", lambda _: taken_at.append(camera.clock()))
    result = offline.calibrate(camera, resume=begun, model="rectilinear", show=listener, clock=camera.clock)
    assert result.used == 4
    assert taken_at[0] > 2.6, "longer than a step of the clock"
    assert 30 < camera.clock() - taken_at[0] < 31
