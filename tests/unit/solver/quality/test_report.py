"""The verdict and the figures behind it."""

import json
import re

import numpy as np
import pytest

from calibsolver import Board, Calibration, View, fit, rotation
from calibsolver.fitting.board_shape import BoardShape
from calibsolver.fitting.coverage import Coverage
from calibsolver.quality.assessment import EDGES, level_of
from calibsolver.quality.report import assess, board_sentence, describe
from tests.helpers.solver import populations, synthetic

CAMERA = synthetic.rectilinear_cameras()[5]


def codes(calibration: Calibration, views: list[View], held_out: float | None = None) -> set[str]:
    return {reason.code for reason in assess(calibration, views, held_out).reasons}


def good() -> tuple[Calibration, list[View]]:
    views = populations.views(CAMERA, np.random.default_rng(0))
    return fit(views, CAMERA.img_size), views


def test_views_in_the_middle_without_tilt() -> None:
    """They face the camera; a mirrored one, tilted and at the rim, takes no part and does not count."""
    board, rng = Board(), np.random.default_rng(0)
    at = np.array([0, 0, 20.0]) - board.outline.mean(axis=0)
    views = [
        synthetic.detect(board, CAMERA, np.radians(rng.uniform(-2, 2, 3)), at + rng.uniform(-1, 1, 3), rng)
        for _ in range(5)
    ]
    verdict = assess(fit(views[:3], CAMERA.img_size), views[:3])
    assert verdict.level == "poor"
    expected = {"no_tilt", "edges_not_covered"}
    assert {"too_few_views"} | expected <= {reason.code for reason in verdict.reasons}
    assert "3 views" in verdict.reasons[0].text
    near = np.array([-4.5, -3.0, 7.0])
    tilted = synthetic.detect(board, CAMERA, np.radians([0.0, 40.0, 0.0]), near, rng)
    flipped = tilted.image_points * (-1, 1) + (CAMERA.img_size[0] - 1.0, 0)
    views.append(View(tilted.object_points, flipped))
    calibration = fit(views, CAMERA.img_size)
    assert calibration.cut_views == {5: "mirrored"}
    assert expected <= codes(calibration, views)


def test_noise_outliers_and_views_left_out() -> None:
    rng = np.random.default_rng(0)
    views = populations.views(CAMERA, rng, noise=2.5)
    noisy = fit(views, CAMERA.img_size)
    assert 1 < noisy.uncertainty().rms < 3
    assert assess(noisy, views).level == "fair"
    assert codes(noisy, views) == {"noisy", "uncertain"}
    views = populations.views(CAMERA, rng)
    wild = []
    for view in views:
        q = view.image_points.copy()
        q[:4] += rng.uniform(10, 40, (4, 2))
        wild.append(View(view.object_points, q))
    assert codes(fit(wild, CAMERA.img_size), wild) == {"outliers"}


@pytest.mark.parametrize(
    ("whole", "inside", "covered", "level"),
    [
        (1.0, 1.0, 0.5, "good"),
        (1.01, 0.2, 0.5, "fair"),
        (3.0, 2.9, 0.5, "fair"),
        (30.0, 1.0, 0.5, "fair"),
        (30.0, 1.0, 0.05, "poor"),
        (3.01, 1.01, 0.9, "poor"),
    ],
)
def test_level_follows_from_two_errors(whole: float, inside: float, covered: float, level: str) -> None:
    assert level_of(whole, inside, covered) == level


@pytest.mark.parametrize("side", EDGES)
def test_side_that_has_not_seen_the_board_is_named_first(side: str) -> None:
    """Views of a good capture without the corners in the outer third at one side."""
    width, height = CAMERA.img_size
    views = []
    for view in populations.views(CAMERA, np.random.default_rng(0), noise=1.5, count=12):
        x, y = view.image_points.T / ((width,), (height,))
        share = {"left": x, "right": 1 - x, "top": y, "bottom": 1 - y}[side]
        inner = share > 1 / 3
        if inner.sum() >= 12:
            views.append(view.subset(inner))
    calibration = fit(views, CAMERA.img_size)
    assessment = assess(calibration, views)
    coverage = Coverage.of(calibration, views)
    assert assessment.level != "good"
    assert coverage.rms < calibration.uncertainty().rms
    assert 0.3 < coverage.share < 0.75
    assert f"{side}_edge_not_covered" in [reason.code for reason in assessment.reasons[:2]]


def test_overfitting_is_reported_by_held_out_views() -> None:
    calibration, views = good()
    train = calibration.avg_reprojection_error
    assert codes(calibration, views, 1.05 * train) == set()
    assert codes(calibration, views, 2 * train) == {"over_fitted"}
    assert assess(calibration, views, 5 * train).level == "poor"


def test_unexplained_views_are_described_in_words() -> None:
    """Two views of eight under other corners' names: what a model says of them may be any number."""
    rng = np.random.default_rng(10)
    camera = synthetic.rectilinear_cameras()[10]
    views = populations.views(camera, rng, count=8)
    for i in range(2):
        views[i] = View(views[i].object_points, rng.permutation(views[i].image_points))
    calibration = fit(views, camera.img_size)
    diagonal = np.hypot(*camera.img_size)
    assert set(calibration.cut_views) == {0, 1}
    assert calibration.avg_reprojection_error < diagonal
    assert calibration.view_errors.max() <= diagonal
    described = describe(calibration, views, held_out=3.1e10)
    assert described["held_out"] is None
    texts = [reason["text"] for reason in described["verdict"]["reasons"]]
    assert any("off by more than the image is wide" in text for text in texts)
    assert not any(len(number) > 4 for text in texts for number in re.findall(r"\d+", text))


def test_description_is_json_of_the_fit() -> None:
    calibration, views = good()
    description = json.loads(json.dumps(describe(calibration, views, indices=[*range(10, 16)], held_out=0.3)))
    assert description["verdict"] == {"level": "good", "reasons": []}
    assert description["held_out"] == 0.3
    std = np.sqrt(np.diag(calibration.covariance))
    assert description["std"]["fx"] == pytest.approx(std[0], rel=0.01)
    assert description["std"]["distortion"] == pytest.approx(std[4:], rel=0.01)
    assert np.array(description["error_map"]["px"]) == pytest.approx(calibration.projection_std(), rel=0.01)
    assert [view["index"] for view in description["views"]] == [*range(10, 16)]
    for i, view in enumerate(description["views"]):
        assert np.array(view["points"]) == pytest.approx(views[i].image_points, abs=0.006)
        assert np.array(view["residuals"]) == pytest.approx(calibration.residuals[i], abs=1e-3)
        assert view["rms"] == pytest.approx(calibration.view_errors[i], abs=1e-4)
        assert view["cut"] == np.flatnonzero(~calibration.used[i]).tolist()
        assert view["reason"] is None
        p = views[i].object_points @ rotation.matrix(np.array(view["rvec"])).T + view["tvec"]
        assert np.sqrt(np.mean((views[i].image_points - CAMERA.project(p)) ** 2)) < 1


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ((0.0, 0.0, 0.006, 0.001, 0.0), "bent by 0.1 % of its length and 0.2 % wider than drawn"),
        ((0.0, 0.0, 0.0, -0.0015, 0.002), "0.3 % narrower than drawn"),
        ((0.0, 0.0, 0.0, 0.0, -0.0006), "skewed by 0.06 %"),
        ((0.0002, 0.0, 0.0, 0.00005, 0.0), None),
    ],
    ids=["both", "narrower", "skewed", "within two standard deviations"],
)
def test_owner_of_a_board_reads_what_is_certain(parameters: tuple[float, ...], sentence: str | None) -> None:
    covariance = np.diag([0.0002, 0.0002, 0.0002, 0.0001, 0.0001]) ** 2
    figures = BoardShape((4.5, 3.0), 3.5, (1.0, 4 / 7), parameters, covariance).figures()
    said = board_sentence(figures)
    assert said == (sentence and f"Your board is {sentence}; that was taken into account.")
    in_mm = board_sentence(figures, length_mm=210)
    assert in_mm == (said and said.replace("0.1 % of its length", "0.2 mm"))
    assert board_sentence(None) is None


def test_print_of_an_old_record_is_out_of_shape() -> None:
    """Records made before `stretch_kind` was stated."""
    said = board_sentence({"sag": 0.0, "sag_std": 0.001, "stretch": 0.003, "stretch_std": 0.001})
    assert said == "Your board is 0.3 % out of shape; that was taken into account."
