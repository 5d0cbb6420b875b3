"""The plain projection of a lookup is the solver's, and goes no further than the picture."""

import math

import numpy as np
import pytest

from calibdb.lookup.projection import distort_ray, rays_in_view
from calibdb.schema import DISTORTION_MODELS, Calibration
from calibsolver import Camera
from tests.helpers.service.known import LENS, consensus, fit
from tests.helpers.vectors import recorded

LENSES = {
    "rectilinear": LENS,
    "fisheye": (-0.02, 0.004, -0.001, 0.0002),
    "rational": (0.3, -0.1, 0.0005, -0.0004, 0.01, 0.5, -0.05, 0.02),
    "omnidirectional": (1.1, -0.2, 0.05, 0.0005, -0.0004),
}


def camera(model: str, f: float = 700.0) -> Calibration:
    found = consensus(fit(f=f, distortion=LENSES[model], model=model)).calibration
    assert found is not None
    return found


@pytest.mark.parametrize("model", DISTORTION_MODELS)
def test_plain_projection_matches_solver(model: str) -> None:
    stored = camera(model, 1400.0 if model == "omnidirectional" else 700.0)
    solver = Camera(model, np.array(stored.camera_matrix), LENSES[model], stored.img_size)
    rays = list(rays_in_view(stored))
    assert len(rays) > 150
    theta, phi = (np.array([ray[i] for ray in rays]) for i in (0, 1))
    v = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    q = np.array([ray[2] for ray in rays])
    assert np.abs(solver.project(v) - q).max() < 1e-9
    assert (q >= -0.5).all()
    assert (q <= np.array(stored.img_size) - 0.5).all()
    assert np.ptp(q, axis=0) == pytest.approx(np.array(stored.img_size), rel=0.25)


def test_plain_projection_matches_the_shared_vectors() -> None:
    count = 0
    for record in recorded("lenses"):
        fx, fy, cx, cy, *d = record["k"]
        for (x, y, z), expected in zip(record["rays"], record["pixels"], strict=True):
            if not x and not y and not z:
                continue  # the centre of the camera has no direction
            theta, phi = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
            at = distort_ray(record["model"], tuple(d), theta, phi)
            assert (at is None) == (expected is None), record
            if at is not None:
                assert math.dist((fx * at[0] + cx, fy * at[1] + cy), expected) < 1e-9, record
            count += 1
    assert count > 2000


def test_folding_model_ends_at_its_fold() -> None:
    folding = consensus(fit(f=300.0, distortion=(-0.4, 0, 0, 0, 0))).calibration
    assert folding is not None
    fold = math.atan(math.sqrt(1 / 1.2))  # d/dr of r (1 - 0.4 r^2) is 0 at r^2 = 1 / 1.2
    assert fold - 0.06 < max(theta for theta, _, _ in rays_in_view(folding)) < fold + 0.06  # to a step
