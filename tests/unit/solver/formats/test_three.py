"""three.js makes of our WebXR and glTF files the cameras that we mean."""

import json

import numpy as np
import pytest

from calibsolver import models
from tests.helpers.node import run_module
from tests.helpers.solver.export_sources import IMG_SIZE, subject, written

PROGRAM = """
import { readFileSync } from 'node:fs';
import { Matrix4, PerspectiveCamera, Vector3 } from 'three';
const { files, points } = JSON.parse(readFileSync(0, 'utf8'));
const at = ([x, y, z]) => new Vector3(x, -y, -z);
const seen = (camera) => points.map((p) => at(p).project(camera).toArray().slice(0, 2));
console.log(JSON.stringify(files.map(({ webxr, gltf }) => {
  const ours = new PerspectiveCamera();
  ours.projectionMatrix = new Matrix4().fromArray(webxr.projectionMatrix);
  ours.projectionMatrixInverse = ours.projectionMatrix.clone().invert();
  ours.updateMatrixWorld();
  // what three's GLTFLoader does with a perspective camera
  const { yfov, aspectRatio, znear, zfar } = gltf.cameras[0].perspective;
  const loaded = new PerspectiveCamera(yfov * 180 / Math.PI, aspectRatio, znear, zfar);
  loaded.updateMatrixWorld();
  return { webxr: seen(ours), gltf: seen(loaded) };
})));
"""
POINTS = np.random.default_rng(2).uniform((-0.5, -0.3, 1), (0.5, 0.3, 5), (40, 3))


@pytest.fixture(scope="module")
def drawn() -> dict[str, dict[str, list[list[float]]]]:
    """Pixels at which three.js draws the points with the files of each model."""
    files = [
        {name: json.loads(written(model, name).content) for name in ("webxr", "gltf")}
        for model in models.NAMES
    ]
    found = run_module(PROGRAM, sent={"files": files, "points": POINTS.tolist()})
    return dict(zip(models.NAMES, found, strict=True))


@pytest.mark.parametrize("model", models.NAMES)
def test_points_are_projected_as_by_the_pinhole(
    model: str, drawn: dict[str, dict[str, list[list[float]]]]
) -> None:
    camera, (w, h) = subject(model).camera, IMG_SIZE
    said = {
        name: np.stack([(q[:, 0] + 1) / 2 * w - 0.5, (1 - q[:, 1]) / 2 * h - 0.5], axis=1)
        for name, q in ((name, np.array(q)) for name, q in drawn[model].items())
    }
    k = np.array(camera.matrix)
    for name, centre in (("webxr", k[:2, 2]), ("gltf", np.array([w - 1, h - 1]) / 2)):
        pinhole = POINTS[:, :2] / POINTS[:, 2:] * (k[0, 0], k[1, 1]) + centre
        assert np.abs(said[name] - pinhole).max() < 1e-9 * w, name
