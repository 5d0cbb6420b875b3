"""Test vectors of the browser's projections equal what the solver computes."""

import json

import numpy as np

from infra.web_build.vectors import VECTORS_PATH, vectors


def test_the_recorded_vectors_are_the_solvers() -> None:
    recorded = json.loads(VECTORS_PATH.read_text())
    computed = vectors()
    assert [each["distortion_model"] for each in recorded] == [each["distortion_model"] for each in computed]
    for old, new in zip(recorded, computed, strict=True):
        assert [ray is None for ray in old["rays"]] == [ray is None for ray in new["rays"]]
        rays = [np.array([ray for ray in each["rays"] if ray is not None]) for each in (old, new)]
        assert np.abs(rays[0] - rays[1]).max() < 1e-9
