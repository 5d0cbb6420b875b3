"""The probable cause of systematic residuals, in simulated hands."""

import numpy as np
import pytest

from calibsolver import CalibrationError, Camera, View, fit
from calibsolver.quality.systematic import probable_cause
from tests.helpers.solver import hands, populations, synthetic


def held_views(
    camera: Camera, rng: np.random.Generator, hand: hands.Hand, monkeypatch: pytest.MonkeyPatch
) -> list[View]:
    board = populations.BOARD
    points = hand.bend(board, rng) if hand.sag_boards else board.points

    def seen(
        _: object, camera: Camera, rvec: np.ndarray, tvec: np.ndarray, rng: np.random.Generator, noise: float
    ) -> View:
        q = hand.project(points, camera, rvec, tvec, rng)
        w, h = camera.img_size
        inside = (q >= 2).all(axis=1) & (q[:, 0] <= w - 3) & (q[:, 1] <= h - 3)
        return View(board.points[inside], q[inside] + noise * rng.normal(size=(int(inside.sum()), 2)))

    monkeypatch.setattr(synthetic, "seen", seen)
    return populations.views(camera, rng, 0.2, 6)


@pytest.mark.parametrize(
    ("hand", "cause"), [(hands.STEADY, None), (hands.MOVING, "motion"), (hands.BENT, "board_bent")]
)
def test_cause_is_named_in_four_of_five_captures(
    hand: hands.Hand, cause: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = []
    for i, camera in enumerate(synthetic.rectilinear_cameras()):
        views = held_views(camera, np.random.default_rng(i), hand, monkeypatch)
        try:
            found = probable_cause(fit(views, camera.img_size), views)
        except CalibrationError:
            continue
        named.append(found.code if found else None)
    assert np.mean([name == cause for name in named]) >= 0.8
