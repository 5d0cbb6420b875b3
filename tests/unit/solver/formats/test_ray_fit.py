"""The ray fit finds a camera of another model wherever there is one that draws the same picture."""

import numpy as np
import pytest

from calibsolver import models
from calibsolver.camera import Camera
from calibsolver.formats.base import ModelConstraint
from calibsolver.formats.ray_fit import fit_to_rays, sampled_rays


@pytest.mark.parametrize(
    ("fx", "fy", "cx", "cy", "k1"),
    [
        (960.639, 969.294, 644.957, 340.453, -0.17527),
        (598.761, 595.207, 648.835, 347.389, -0.17478),
        (1045.115, 1051.512, 641.305, 336.679, 0.00432),
    ],
)
def test_unified_camera_model_contains_every_plane(
    fx: float, fy: float, cx: float, cy: float, k1: float
) -> None:
    camera = Camera.from_intrinsics("rectilinear", np.array([fx, fy, cx, cy, k1, 0.05, 0, 0, 0]), (1280, 720))
    found = fit_to_rays(camera, ModelConstraint("omnidirectional"))
    model = models.get("omnidirectional")
    rays, q = sampled_rays(camera, model.max_angle)
    assert np.abs(model.project(found.intrinsics, rays) - q).max() < 1e-3  # px
