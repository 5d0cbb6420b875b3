"""Test vectors tests/web/vectors.json: rays and pixels of every camera model, as the solver computes them.

    python -m infra.web_build.vectors

The pages and the SDK compute projections themselves; their tests compare with these.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from calibsolver import Camera, models

VECTORS_PATH = Path(__file__).parents[2] / "tests" / "web" / "vectors.json"
SIZE = (1280, 720)
# Some bend inwards, some outwards, some not at all; of the wide models one sees beyond 90 degrees.
LENSES: dict[str, list[tuple[float, list[float]]]] = {
    "rectilinear": [
        (1000.0, [-0.25, 0.06, 0.001, -0.0008, -0.004]),
        (700.0, [0.08, -0.02, -0.001, 0.0005, 0.001]),
        (1400.0, [0.0, 0.0, 0.0, 0.0, 0.0]),
    ],
    "fisheye": [
        (420.0, [-0.02, 0.003, -0.002, 0.0003]),
        (260.0, [0.05, -0.01, 0.001, 0.0]),
        (600.0, [0.0, 0.0, 0.0, 0.0]),
    ],
    "rational": [
        (800.0, [1.2, 0.3, 0.0005, -0.0004, 0.02, 1.5, 0.6, 0.06]),
        (900.0, [-0.3, 0.1, -0.001, 0.001, -0.01, 0.02, 0.01, 0.001]),
    ],
    "omnidirectional": [
        (900.0, [1.2, -0.1, 0.02, 0.0006, -0.0003]),
        (450.0, [0.6, 0.03, -0.005, -0.0004, 0.0005]),
    ],
}


def vectors() -> list[dict[str, Any]]:
    """Return one record a lens: its intrinsics, pixels all over the image, and their unit rays or null."""
    u, v = np.meshgrid(np.linspace(-0.5, SIZE[0] - 0.5, 9), np.linspace(-0.5, SIZE[1] - 0.5, 7))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    records = []
    for model in models.NAMES:
        for focal, coefficients in LENSES[model]:
            matrix = np.array([[focal, 0, 650.25], [0, 1.01 * focal, 352.5], [0, 0, 1.0]])
            camera = Camera(model=model, matrix=matrix, distortion=np.array(coefficients), img_size=SIZE)
            rays = camera.unproject(pixels).round(12)
            seen = np.asarray(np.isfinite(rays).all(axis=1))
            records.append(
                {
                    "camera_matrix": matrix.tolist(),
                    "distortion_coefficients": coefficients,
                    "distortion_model": model,
                    "pixels": pixels.tolist(),
                    "rays": [ray if ok else None for ray, ok in zip(rays.tolist(), seen, strict=True)],
                }
            )
    return records


if __name__ == "__main__":
    VECTORS_PATH.write_text(json.dumps(vectors()) + "\n")
