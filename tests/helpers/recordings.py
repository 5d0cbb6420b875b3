"""Recordings of the Python client, made of corner sets of real photographs."""

from calibdb_client import Board, CameraKey, Recording
from calibdb_client.recording import RecordedView
from calibsolver.formats.grid import grid
from tests.helpers.data import corner_views


def recording_of(name: str, camera: str = "Test camera") -> Recording:
    """Return the recording of a corner set, as of a chessboard."""
    views, size = corner_views(name)
    numbered = grid(views)
    recorded = tuple(
        RecordedView(f"{i:02d}.jpg", ids, tuple((x, y) for x, y in view.image_points.tolist()))
        for i, (ids, view) in enumerate(zip(numbered.ids, views, strict=True))
    )
    key = CameraKey(camera, "photographs", size)
    return Recording(key, Board(numbered.squares, kind="chessboard"), recorded)
