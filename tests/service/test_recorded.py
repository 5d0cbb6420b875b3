"""Sessions of views that are all there already."""

import numpy as np
import pytest

from calibsolver import View, fit
from tests.helpers.data import available, corner_views, on_board
from tests.helpers.marks import thorough
from tests.helpers.service.client import Client, Truth

JOBS = False
NAMES = available(["opencv_left", "pv_charuco_480"])


def recorded(client: Client, name: str) -> tuple[tuple[tuple[int, ...], ...], tuple[View, ...]]:
    """Start a recorded session of a real corner set; ids and views on the session's board."""
    views, size = corner_views(name)
    board, ids, seen = on_board(views)
    sent = {"squares": list(board.squares), "dictionary": board.dictionary}
    opened = client.open(camera=f"Recorded {name}", img_size=list(size), board=sent, capture="recorded")
    assert opened.status == 201, opened.body
    assert opened.json["capture"] == "recorded"
    return ids, seen


@pytest.mark.parametrize("name", [NAMES[-1], *thorough(*NAMES[:-1])])
def test_every_real_view_that_agrees_counts(client: Client, name: str) -> None:
    ids, views = (each[::2] for each in recorded(client, name))  # all of them only take longer
    taken = []
    for i, view in zip(ids, views, strict=True):
        answer = client.view(len(taken), i, view.image_points.tolist()).json
        assert answer["status"] == "capturing", "no error and no number of views ends it"
        assert answer["reason"] != "duplicate"
        taken += [view] if answer["accepted"] else []
    ended = client.finish().json
    assert ended["status"] == "converged"
    used = [v for v, state in zip(taken, ended["views"], strict=True) if state["set_aside"] is None]
    assert len(used) >= len(views) - 1, "one of another board, or blurred, may contradict the others"
    expected = fit(used, tuple(ended["img_size"]))
    assert np.allclose(ended["calibration"]["camera_matrix"], expected.camera.matrix, rtol=1e-4)
    assert client.finish().json == ended, "again is answered again"
    stored = client.calibration(ended["calibration_id"]).json
    assert len(stored["report"]["views"]) == len(used)
    shape = expected.board_shape
    assert ("board_shape" in stored) == (shape is not None), "missing where the board is as drawn"
    if shape is not None:
        assert stored["board_shape"]["sag"] == pytest.approx(shape.sag, rel=0.05)


def test_duplicate_counts_where_it_is_recorded_only(client: Client) -> None:
    ids, points = Truth().see({"rvec": [0.3, 0.4, 0], "tvec": [-4, -3, 9]})
    near = [[x + 3, y] for x, y in points]
    for mode in ("live", "recorded"):
        assert client.open(camera=mode, capture=mode).json["capture"] == mode
        assert client.view(0, ids, points).json["accepted"]
        assert client.view(1, ids, near).json["accepted"] == (mode == "recorded")


def test_live_capture_can_be_ended_before_its_target_error(client: Client) -> None:
    truth = Truth()
    client.open(camera="Live", target_error=0.01)
    for _ in range(4):
        assert client.finish().problem == (409, "too-few-views")
        assert truth.show(client).json["accepted"]
    ended = client.finish().json
    assert (ended["status"], len(ended["views"])) == ("converged", 4)
    assert ended["uncertainty"]["rms"] > 0.01, "it says what it is worth, whatever was asked"
    assert client.calibration(ended["calibration_id"]).status == 200
