"""Poses of boards and their covariances."""

import cv2
import numpy as np
import pytest

from calibsolver import Board, BoardPose, Calibration, CalibrationError, Camera, View, fit, locate, rotation
from tests.helpers.data import corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver import export_sources

SIZE = (1280, 720)
MODELS = tuple(export_sources.TRUTH)
BOARD = Board((9, 6))
NOISE = 0.3
"""Per model: 2,000 in all."""
CHI2_68, CHI2_95 = 7.0092, 12.5916
"""Quantiles of chi square with 6 degrees of freedom at 0.68 and 0.95."""


def camera_of(model: str, change: np.ndarray | float = 0.0) -> Camera:
    return Camera.from_intrinsics(model, export_sources.truth(model).intrinsics + change, SIZE)


def calibration_of(model: str) -> Calibration:
    camera = camera_of(model)
    sigmas = np.array([1.5, 1.5, 2.0, 2.0, *([0.002] * len(camera.distortion))])
    names = len(sigmas)
    mixed = np.eye(names) + 0.3 * np.outer(np.ones(names), np.linspace(-1, 1, names))
    covariance = np.diag(sigmas) @ (mixed @ mixed.T / 1.3) @ np.diag(sigmas)
    none: tuple[np.ndarray, ...] = ()
    return Calibration(
        camera, np.zeros((0, 6)), NOISE, np.zeros(0), covariance, np.linalg.inv(covariance), NOISE, 1.0,
        none, none, False,
    )  # fmt: skip


def poses(model: str, count: int, rng: np.random.Generator) -> list[tuple[np.ndarray, np.ndarray]]:
    camera, out = camera_of(model), []
    middle = np.array([*BOARD.points[:, :2].mean(axis=0), 0])
    while len(out) < count:
        rvec = np.append(rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.5, 0.5))
        r = rotation.matrix(rvec)
        place = rng.uniform([-6, -4, 8], [6, 4, 16])
        t = place - r @ middle
        q = camera.project(BOARD.points @ r.T + t)
        if np.isfinite(q).all() and ((q > 0) & (q < SIZE)).all() and np.linalg.norm(rvec[:2]) > 0.2:
            out.append((r, t))
    return out


def mahalanobis(found: BoardPose, r: np.ndarray, t: np.ndarray) -> float:
    """Squared distance of a true pose from an estimated one, in units of the covariance."""
    turn = rotation.vector(r @ rotation.matrix(np.asarray(found.rvec)).T)
    error = np.concatenate([turn, t - found.tvec])
    return float(error @ np.linalg.solve(found.covariance, error))


def distances_of(model: str, rng: np.random.Generator, count: int) -> list[float]:
    """Squared distances of true poses from ones estimated by a camera that errs as it states."""
    calibration = calibration_of(model)
    root = np.linalg.cholesky(calibration.covariance)
    distances = []
    for r, t in poses(model, count, rng):
        true = camera_of(model, root @ rng.normal(size=len(root)))
        q = true.project(BOARD.points @ r.T + t) + rng.normal(size=(BOARD.corner_count, 2)) * NOISE
        distances.append(mahalanobis(locate(calibration, View(BOARD.points, q)), r, t))
    return distances


@pytest.mark.parametrize("count", [40, *thorough(500)])
def test_covariance_covers_the_errors_of_simulated_poses(count: int) -> None:
    """Within three times the Monte Carlo error."""
    rng = np.random.default_rng(45)
    distances = np.array([distances_of(model, rng, count) for model in MODELS])
    for limit, share in ((CHI2_68, 0.68), (CHI2_95, 0.95)):
        bound = 3 * np.sqrt(share * (1 - share) / count)
        assert float((distances < limit).mean()) == pytest.approx(share, abs=bound / 2)
        assert (distances < limit).mean(axis=1) == pytest.approx([share] * 4, abs=bound)


@pytest.mark.parametrize("model", MODELS)
def test_pose_without_noise_is_exact(model: str) -> None:
    (r, t), *_ = poses(model, 1, np.random.default_rng(3))
    found = locate(camera_of(model), View(BOARD.points, camera_of(model).project(BOARD.points @ r.T + t)))
    assert np.abs(found.matrix[:3, :3] - r).max() < 1e-9
    assert np.abs(found.tvec - t).max() < 1e-7
    assert found.rms < 1e-9


def test_poses_in_real_photographs_are_opencvs() -> None:
    views, size = corner_views("opencv_left")
    calibration = fit(views, size)
    k, d = np.asarray(calibration.camera.matrix), np.asarray(calibration.camera.distortion)
    for view in views:
        found = locate(calibration, view)
        points = np.asarray(view.object_points), np.asarray(view.image_points)
        _, rvec, tvec = cv2.solvePnP(*points, k, d, flags=cv2.SOLVEPNP_ITERATIVE)
        assert np.abs(found.rvec - rvec.ravel()).max() < 1e-4
        assert np.abs(found.tvec - tvec.ravel()).max() < 1e-3
        exact = locate(calibration.camera, view, noise=found.noise)
        assert np.trace(exact.covariance) < np.trace(found.covariance)


def test_too_few_points_are_refused() -> None:
    with pytest.raises(CalibrationError, match="6 points"):
        locate(camera_of("fisheye"), View(BOARD.points[:5], np.zeros((5, 2))))


def test_weights_make_poses_of_uneven_corners_certain() -> None:
    rng = np.random.default_rng(1)
    sigma = np.where(np.arange(BOARD.corner_count) % 3 == 0, 1.5, NOISE)
    camera, squares, shares = camera_of("rectilinear"), [], []
    for r, t in poses("rectilinear", 80, rng):
        q = camera.project(BOARD.points @ r.T + t) + sigma[:, None] * rng.normal(size=(len(sigma), 2))
        found = locate(camera, View(BOARD.points, q, sigma**-2.0))
        squares.append(mahalanobis(found, r, t))
        plain = locate(camera, View(BOARD.points, q))
        shares.append(np.trace(found.covariance[3:, 3:]) / np.trace(plain.covariance[3:, 3:]))
    assert np.mean(np.array(squares) < CHI2_95) == pytest.approx(0.95, abs=0.05)
    assert np.median(shares) < 0.5
