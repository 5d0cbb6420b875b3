"""Recordings of the Python client, made of corner sets of real photographs."""

import functools

import pytest

from calibdb_client import Board, CameraKey, CaptureResult, Recording, offline
from calibdb_client.key import AUTO
from calibdb_client.model_choice import chosen_model
from calibdb_client.recording import RecordedView
from calibsolver.formats.grid import grid
from tests.helpers.data import corner_views


@functools.cache
def recording_of(name: str, camera: str = "Test camera") -> Recording:
    views, size = corner_views(name)
    numbered = grid(views)
    recorded = tuple(
        RecordedView(f"{i:02d}.jpg", ids, tuple((x, y) for x, y in view.image_points.tolist()))
        for i, (ids, view) in enumerate(zip(numbered.ids, views, strict=True))
    )
    key = CameraKey(camera, "photographs", size)
    return Recording(key, Board(numbered.squares, kind="chessboard"), recorded)


def without_suggestion(recording: Recording, model: str) -> tuple[str, str | None]:
    """Choose a model as the client does, but look for none that is better than a given one."""
    return chosen_model(recording, model) if model == AUTO else (model, None)


@functools.cache
def calibration_of(name: str) -> CaptureResult:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(offline, "chosen_model", without_suggestion)
        return offline.calibrate_recording(recording_of(name), "rectilinear")
