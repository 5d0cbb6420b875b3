"""Test vectors of the browser's projections and rectifications."""

import json
from collections import Counter

import numpy as np
import pytest

from calibsolver import Camera, models
from calibsolver.models.planar import Planar
from tests.helpers.lens_vectors import SIZE, assert_agrees, recorded
from tests.helpers.rig_vectors import RIGS_PATH, pair_record


def test_recorded_rays_and_pixels_are_the_solvers() -> None:
    assert_agrees(lambda model, k: Camera.from_intrinsics(model, k, SIZE))
    counts = Counter(record["model"] for record in recorded())
    assert counts == {"rectilinear": 101, "fisheye": 100, "rational": 100, "omnidirectional": 100}
    assert recorded()[0]["pixels"][0] is None  # the tangential part exceeds the stretch


@pytest.mark.parametrize("model", ["rectilinear", "rational", "omnidirectional"])
def test_planar_models_are_one_to_one_out_to_the_edge_of_the_domain(model: str) -> None:
    circle = np.linspace(0, 2 * np.pi, 60)
    for record in recorded():
        if record["model"] != model:
            continue
        planar, d = models.get(model), np.array(record["k"][4:])
        assert isinstance(planar, Planar)
        for share in (0.2, 0.5, 0.8, 1 - 1e-9):
            r = share * planar.domain_radius(d)
            _, _, ux, uy, vy = planar.distort_plane_jacobian(d, r * np.cos(circle), r * np.sin(circle))
            assert (ux + vy > 0).all()
            assert (ux * vy - uy * uy > 0).all()


def test_the_recorded_rectifications_are_the_solvers() -> None:
    recorded = json.loads(RIGS_PATH.read_text())
    assert len(recorded) == 18
    for old in recorded:
        left, right = (Camera.from_record(old[side]) for side in ("left", "right"))
        new = pair_record(left, right, [*old["pose"]["rvec"], *old["pose"]["tvec"]])
        for name in ("R1", "R2", "P1", "P2", "Q"):
            assert np.abs(np.array(old[name]) - np.array(new[name])).max() < 1e-9, name
