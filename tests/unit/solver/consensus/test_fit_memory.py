"""Cache of members' fits."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from calibsolver import Calibration, CalibrationError, View, fit
from calibsolver.consensus import Member, Rule, fit_memory, pool
from tests.helpers.solver import populations, synthetic

CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size


def member(seed: int) -> Member:
    return populations.member(f"m{seed}", CAMERA, np.random.default_rng(seed), count=4)


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    made: list[str] = []

    def counted(
        views: Sequence[View], img_size: tuple[int, int], model: str, *, board_shape: bool = False
    ) -> Calibration:
        made.append(model)
        return fit(views, img_size, model, board_shape=board_shape)

    monkeypatch.setattr(fit_memory, "fit", counted)
    fit_memory.forget()
    yield made
    fit_memory.forget()


def test_a_new_calibration_alone_is_fitted(fitted: list[str]) -> None:
    members = [member(seed) for seed in range(3)]
    pool(members[:2], SIZE, "rectilinear")
    assert fitted == ["rectilinear"] * 2
    again = [replace(m, views=tuple(replace(view) for view in m.views)) for m in members]
    warm = pool(again, SIZE, "rectilinear")
    assert fitted == ["rectilinear"] * 3  # their documents were read anew
    pool(again, SIZE, "rectilinear", Rule(min_contributors=1, min_calibrations=1))
    assert fitted == ["rectilinear"] * 3
    fit_memory.forget()
    cold = pool(members, SIZE, "rectilinear")
    assert cold.calibration.record() == warm.calibration.record()


def test_nothing_else_is_taken_for_it(fitted: list[str]) -> None:
    views = member(1).views
    shifted = [View(v.object_points, v.image_points + 1e-9) for v in views]
    weighed = [View(v.object_points, v.image_points, np.arange(1.0, len(v) + 1)) for v in views]
    scaled = [View(2 * v.object_points, v.image_points) for v in views]
    for each, size, model in (
        (views, SIZE, "rectilinear"),
        (shifted, SIZE, "rectilinear"),
        (scaled, SIZE, "rectilinear"),
        (weighed, SIZE, "rectilinear"),
        (views[::-1], SIZE, "rectilinear"),
        (views, (SIZE[0], SIZE[1] + 2), "rectilinear"),
        (views, SIZE, "rational"),
    ):
        assert fit_memory.fit_once(each, size, model).camera.img_size == size
    assert len(fitted) == 7
    for _ in range(2):  # a refusal is not remembered
        with pytest.raises(CalibrationError):
            fit_memory.fit_once([], SIZE, "rectilinear")
    assert len(fitted) == 9


def test_consensus_of_one_calibration_is_its_fit(fitted: list[str]) -> None:
    one = member(1)
    alone = pool([one], SIZE, "rectilinear")
    assert alone.calibration is fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert fitted == ["rectilinear"]


def test_cache_beyond_its_points_drops_the_oldest_fit(
    fitted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    members = [member(seed) for seed in range(4)]
    points = [sum(map(len, m.views)) for m in members]
    monkeypatch.setattr(fit_memory, "MAX_POINTS", sum(points[1:]))
    for one in members:
        fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert fit_memory.cached_points() == sum(points[1:])
    for one in (*members[1:], members[0]):
        fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert len(fitted) == 5
