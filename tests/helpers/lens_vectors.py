"""Shared test vectors `tests/data/lens_vectors.json`: 400 random cameras, their rays and pixels.

`python -m tests.helpers.lens_vectors` writes them by the solver. A record is a camera: its model, `k` (fx fy
cx cy and the distortion), rays with their pixels (null outside the valid domain), pixels that a ray of the
domain meets (`seen`), and pixels that none does (`missed`).
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibsolver import Camera, models

LENS_VECTORS_PATH = Path(__file__).parents[1] / "data" / "lens_vectors.json"
CAMERAS_PER_MODEL = 100
SIZE = (1280, 720)
# Of the largest angle of the valid domain: on the axis, to just within the edge, and beyond it.
SHARES = (0.0, 0.3, 0.7, 0.999, 1 - 1e-6, 1 + 1e-6, 1.05)
MAX_PIXEL = 5e3  # px: rays that meet the plane farther out are left out; doubles end at 1e-9 px soon after
EXAMPLE = (
    "rectilinear",
    [900.0, 900.0, 640.0, 360.0, -0.273, -0.099, 0.003, 0.0, -0.239],
    [0.778, 0.261, 1.07],
)


def recorded() -> list[dict[str, Any]]:
    records: list[dict[str, Any]] = json.loads(LENS_VECTORS_PATH.read_text())
    return records


def assert_agrees(lens_of: Callable[[str, NDArray[np.float64]], Any]) -> None:
    """Assert that lenses with `project` and `unproject` agree with the file: to 1e-9 px, and NaN for NaN.

    `lens_of` makes one of a model's name and its intrinsics.
    """
    count = 0
    for record in recorded():
        what = f"{record['model']} {record['k']}"
        lens = lens_of(record["model"], np.array(record["k"]))
        expected = np.array([q or [np.nan, np.nan] for q in record["pixels"]])
        pixels = lens.project(np.array(record["rays"]))
        assert np.array_equal(np.isnan(pixels), np.isnan(expected)), what
        assert np.nanmax(np.abs(pixels - expected), initial=0) < 1e-9, what
        seen, missed = (np.array(record[name]).reshape(-1, 2) for name in ("seen", "missed"))
        assert np.abs(lens.project(lens.unproject(seen)) - seen).max(initial=0) < 1e-9, what
        assert np.isnan(lens.unproject(missed)).all(), what
        count += len(pixels)
    assert count > 2000


def vectors() -> list[dict[str, Any]]:
    rng = np.random.default_rng(30)
    model, k, ray = EXAMPLE
    records = [_record(model, k, np.array([ray, [0.4, -0.2, 1.0], [0.0, 0.0, 0.0]]), rng)]
    for name in models.NAMES:
        for number in range(CAMERAS_PER_MODEL):
            focal = round(float(rng.uniform(200, 1800)), 2)
            center = (np.array([639.5, 359.5]) + rng.normal(size=2) * 25).round(2)
            k = [focal, round(focal * 1.01, 2), *center.tolist(), *_distortion(name, number, rng)]
            records.append(_record(name, k, _rays(_camera(name, k), rng), rng))
    return records


def _distortion(name: str, number: int, rng: np.random.Generator) -> list[float]:
    """Coefficients from none (every tenth) to far stronger than those of lenses."""
    scale = 0.0 if number % 10 == 0 else float(rng.choice([0.1, 0.4, 1.0, 2.0]))
    tangential = float(rng.choice([0.0, 0.001, 0.01, 0.1]))
    by_order = {"1": 0.5, "4": 0.7}
    sigmas = [
        tangential if coefficient[0] == "p" else by_order.get(coefficient[-1], 0.3)
        for coefficient in models.get(name).coefficients
    ]
    d = scale * rng.normal(size=len(sigmas)) * sigmas
    if name == "omnidirectional":
        d[0] = rng.choice([-0.4, 0.0, 0.7, 1.0, 1.2, 2.5]) + 0.1 * scale * rng.normal()
    return [float(c) for c in d.round(5)]


def _rays(camera: Camera, rng: np.random.Generator) -> NDArray[np.float64]:
    """Rays at shares of the domain's angle and anywhere else, of any length."""
    theta = np.concatenate([np.array(SHARES) * camera.domain().angle, rng.uniform(0, np.pi, 2)])
    phi = rng.uniform(0, 2 * np.pi, len(theta))
    v = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    rays: NDArray[np.float64] = (v * rng.uniform(0.5, 5, (len(theta), 1))).round(9)
    return rays[~(np.abs(camera.project(rays)) > MAX_PIXEL).any(axis=1)]


def _record(name: str, k: list[float], rays: NDArray[np.float64], rng: np.random.Generator) -> dict[str, Any]:
    camera = _camera(name, k)
    pixels = camera.project(rays)
    drawn = np.concatenate([pixels[np.isfinite(pixels[:, 0])][:4], rng.uniform(-1, 2, (5, 2)) * SIZE]).round(
        2
    )
    is_seen = np.isfinite(camera.unproject(drawn)[:, 0])
    return {
        "model": name,
        "k": k,
        "rays": rays.tolist(),
        "pixels": [q if np.isfinite(q).all() else None for q in pixels.round(10).tolist()],
        "seen": drawn[is_seen].tolist(),
        "missed": drawn[~is_seen].tolist(),
    }


def _camera(name: str, k: list[float]) -> Camera:
    return Camera.from_intrinsics(name, np.array(k), SIZE)


if __name__ == "__main__":
    lines = ",\n".join(json.dumps(record, separators=(",", ":")) for record in vectors())
    LENS_VECTORS_PATH.write_text(f"[\n{lines}\n]\n")
