"""Information of a view that is limited by what hands and boards add to its corners."""

import numpy as np
import pytest

from calibsolver import Board, models, rotation
from calibsolver.fitting.normal_equations import Poses, linearize, reduced_information
from calibsolver.fitting.systematic_effects import displacements, row_position
from calibsolver.guidance.posterior import IntrinsicsPosterior, systematic_share
from tests.helpers.solver import synthetic

CAMERA = synthetic.rectilinear_cameras()[4]
MODEL, K = models.get(CAMERA.model), CAMERA.intrinsics
BOARD = Board()
POSES = Poses.of_vectors(np.array([[0.1, 0.5, 0.2, -4.0, -2.0, 7.0], [-0.7, 0.1, 0.0, -3.0, -3.0, 6.0]]))
POINTS = np.ascontiguousarray(BOARD.points.T)


def limited(noise: float, systematic: float) -> np.ndarray:
    posterior = IntrinsicsPosterior(MODEL, K, np.eye(len(K)), noise, (1280, 720), systematic)
    return posterior.limited_information(POSES, POINTS, np.ones((2, POINTS.shape[1])))[0] / noise**2


def test_without_systematic_errors_it_is_fisher_information() -> None:
    _, rows = linearize(MODEL, K, POSES, POINTS, 0)
    np.testing.assert_allclose(limited(1.0, 0.0).sum(axis=0), reduced_information(rows), rtol=1e-6)


def test_information_is_limited_the_more_the_lower_the_noise() -> None:
    """Share of the information of white noise that is left, direction by direction: (1 + N T)^-1."""
    left = []
    for noise in (0.2, 0.02):
        white = limited(noise, 0.0)[0]
        scale = 1 / np.sqrt(np.diagonal(white))
        whiten = np.linalg.inv(np.linalg.cholesky(white * scale[:, None] * scale)) * scale
        share = np.linalg.eigvalsh(whiten @ limited(noise, 1.0)[0] @ whiten.T)
        assert share.max() < 1 + 1e-6
        left.append(share.min())
    assert left[0] < 0.5
    assert left[1] < 0.1 * left[0]


@pytest.mark.parametrize("cause", range(9))
def test_displacements_are_those_of_bend_and_motion(cause: int) -> None:
    """Against a board that is bent, or moved by its row, by a small step."""
    q, rows = linearize(MODEL, K, POSES, POINTS, 0)
    found = displacements(rows[MODEL.size :], POSES, POINTS, row_position(q[1], 720))[cause]
    center, half = POINTS.mean(axis=1), 3.5
    x, y = (POINTS[:2] - center[:2, None]) / half
    r, t = POSES.r[0], POSES.t[0]
    late = (q[1, 0] - 359.5) / 360
    if cause < 3:
        bent = POINTS.copy()
        bent[2] = 0.003 * 2 * half * (x * x, x * y, y * y)[cause]
        p = (r @ bent).T + t
    else:
        step = np.zeros(6)
        step[cause - 3] = 0.001 if cause < 6 else 0.001 * 2 * half
        turned = np.einsum("nij,nj->ni", rotation.matrix(late[:, None] * step[:3]), (r @ POINTS).T)
        p = turned + t + late[:, None] * step[3:]
    np.testing.assert_allclose(CAMERA.project(p) - q[:, 0].T, found[:, 0].T, rtol=0.03, atol=0.02)


def test_share_follows_the_inflation() -> None:
    assert systematic_share(1.0) == systematic_share(0.5) == 0.0
    assert systematic_share(4.5) == pytest.approx(1.0)
    assert systematic_share(1e6) == 3.0
