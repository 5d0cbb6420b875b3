"""Test vectors of the browser's projections and rectifications equal what the solver computes."""

import json
from typing import Any

import numpy as np

from calibsolver import Camera
from infra.web_build.rig_vectors import RIGS_PATH, pair_record
from infra.web_build.vectors import VECTORS_PATH, vectors


def test_the_recorded_vectors_are_the_solvers() -> None:
    recorded = json.loads(VECTORS_PATH.read_text())
    computed = vectors()
    assert [each["distortion_model"] for each in recorded] == [each["distortion_model"] for each in computed]
    for old, new in zip(recorded, computed, strict=True):
        assert [ray is None for ray in old["rays"]] == [ray is None for ray in new["rays"]]
        rays = [np.array([ray for ray in each["rays"] if ray is not None]) for each in (old, new)]
        assert np.abs(rays[0] - rays[1]).max() < 1e-9


def test_the_recorded_rectifications_are_the_solvers() -> None:
    recorded = json.loads(RIGS_PATH.read_text())
    assert len(recorded) == 18
    for old in recorded:
        left, right = (camera(old[side]) for side in ("left", "right"))
        new = pair_record(left, right, [*old["pose"]["rvec"], *old["pose"]["tvec"]])
        for name in ("R1", "R2", "P1", "P2", "Q"):
            assert np.abs(np.array(old[name]) - np.array(new[name])).max() < 1e-9, name


def camera(record: dict[str, Any]) -> Camera:
    matrix, distortion = np.array(record["camera_matrix"]), np.array(record["distortion_coefficients"])
    w, h = record["img_size"]
    return Camera(model=record["distortion_model"], matrix=matrix, distortion=distortion, img_size=(w, h))
