"""The predicted error of a projection, against the error itself."""

import numpy as np
import pytest

from calibsolver import Calibration, View, fit, models
from calibsolver.uncertainty import pixel_grid, sensitivity
from tests import synthetic


def sessions(kind: str, count: int) -> list[tuple[float, float, np.ndarray]]:
    """Rms error, predicted rms, normalised errors of the intrinsics: fits to ten views, noise anew each."""
    cameras = synthetic.rectilinear_cameras() if kind == "rectilinear" else synthetic.fisheye_cameras()
    out = []
    for i in (2, 7):
        camera = cameras[i]
        rng = np.random.default_rng(40 + i)
        clean = synthetic.run(camera, rng, noise=0.0, views=10).views
        for _ in range(count // 2):
            views = [
                View(v.object_points, v.image_points + 0.2 * rng.normal(size=(len(v), 2))) for v in clean
            ]
            c = fit(views, camera.img_size, kind)
            error = synthetic.projection_error(camera, c.camera)
            z = (c.camera.intrinsics - camera.intrinsics) / np.sqrt(np.diag(c.covariance))
            out.append((float(np.sqrt(np.mean(error**2))), c.uncertainty().rms, z))
    return out


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_prediction_is_the_error_that_happens(kind: str) -> None:
    results = sessions(kind, 40)
    ratio = np.sqrt(np.mean([(actual / predicted) ** 2 for actual, predicted, _ in results]))
    assert 0.8 < ratio < 1.25
    z = np.stack([z for _, _, z in results])
    assert 0.85 < np.sqrt(np.mean(z**2)) < 1.15
    assert np.mean(np.abs(z) < 1.96) > 0.9


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_noise_is_estimated(kind: str) -> None:
    cameras = synthetic.rectilinear_cameras() if kind == "rectilinear" else synthetic.fisheye_cameras()
    for noise in (0.1, 0.5):
        views = synthetic.run(cameras[5], np.random.default_rng(1), noise=noise, views=8).views
        c = fit(views, cameras[5].img_size, kind)
        assert c.noise == pytest.approx(noise, rel=0.12)
        assert c.avg_reprojection_error == pytest.approx(noise * np.sqrt(2), rel=0.12)


def test_a_turn_of_the_camera_is_no_error() -> None:
    """Moving the principal point of a long lens is nearly a rotation: little is left of it."""
    model = models.get("rectilinear")
    d = sensitivity(model, model.start(20_000, (1280, 720)), (1280, 720), (20, 15))
    assert np.abs(d[:, 0, 2]).max() < 0.01
    assert np.abs(d[:, 1, 3]).max() < 0.01
    x = pixel_grid((1280, 720), (20, 15))[0].reshape(-1) - 639.5
    np.testing.assert_allclose(d[:, 0, 0], x / 20_000, atol=1e-4)


def test_grid_and_summary_agree() -> None:
    camera = synthetic.rectilinear_cameras()[6]
    c = synthetic.run(camera, np.random.default_rng(0), views=5).calibration
    assert isinstance(c, Calibration)
    std = c.projection_std((20, 15))
    assert std.shape == (15, 20)
    assert c.uncertainty().max == pytest.approx(np.nanmax(std))
    assert c.uncertainty().rms == pytest.approx(np.sqrt(np.nanmean(std**2)))
    # The middle of the image is known better than its corners.
    assert std[7, 10] < std[0, 0]
    np.testing.assert_allclose(c.covariance, c.covariance.T)
    assert np.linalg.eigvalsh(c.covariance / np.sqrt(np.outer(*[np.diag(c.covariance)] * 2))).min() > 0
