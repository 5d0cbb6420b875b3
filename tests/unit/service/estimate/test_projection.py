"""The plain projection of a lookup is the solver's, and its rays end at the picture or the fold."""

import math

import pytest

from calibdb.estimate.projection import distort_ray, rays_in_view
from tests.helpers.service.known import consensus, fit
from tests.helpers.vectors import recorded


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


@pytest.mark.parametrize(
    ("model", "f", "distortion"),
    [
        ("rectilinear", 700.0, (-0.12, 0.05, 0.0005, -0.0004, 0.0)),
        ("fisheye", 700.0, (-0.02, 0.004, -0.001, 0.0002)),
        ("omnidirectional", 1400.0, (1.1, -0.2, 0.05, 0.0005, -0.0004)),
    ],
)
def test_rays_reach_the_edges_of_the_picture(model: str, f: float, distortion: tuple[float, ...]) -> None:
    camera = consensus(fit(f=f, distortion=distortion, model=model)).calibration
    u, v = zip(*(pixel for _, _, pixel in rays_in_view(camera)), strict=True)
    for coordinates, side in zip((u, v), camera.img_size, strict=True):
        assert len(coordinates) > 150
        assert -0.5 <= min(coordinates) < 0.2 * side
        assert 0.8 * side < max(coordinates) <= side - 0.5


def test_folding_model_ends_at_its_fold() -> None:
    folding = consensus(fit(f=300.0, distortion=(-0.4, 0, 0, 0, 0))).calibration
    fold = math.atan(math.sqrt(1 / 1.2))  # d/dr of r (1 - 0.4 r^2) is 0 at r^2 = 1 / 1.2
    assert fold - 0.06 < max(theta for theta, _, _ in rays_in_view(folding)) < fold + 0.06  # to a step
