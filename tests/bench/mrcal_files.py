"""`python -m tests.bench.mrcal_files`: exports for mrcal, judged by mrcal.

Is the file at its optimum, and what is mrcal's deviation, next to that of calibDB's normal equations by
mrcal's definition: white noise, rotation and place fixed by the boards, root mean square of both axes?
mrcal runs under the interpreter `MRCAL_PYTHON`, by default where Debian installs python3-mrcal.
"""

import json
import os
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from calibsolver import Board, Calibration, CalibrationError, Camera, View, fit, formats, models, rotation
from calibsolver import image_transform as transforms
from calibsolver.arrays import Array, symmetric_inverse
from calibsolver.fitting.normal_equations import POSE_SIZE, Poses, linearize
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportSource
from calibsolver.formats.mrcal import MIN_USED_POINTS, Mrcal
from tests.bench.document import table
from tests.helpers.data import available, corner_views, on_board
from tests.helpers.solver.export_sources import captured, subject

MRCAL_PYTHON = os.environ.get("MRCAL_PYTHON", "/usr/bin/python3")
JUDGE = """
import json, sys
import mrcal, numpy as np
for path in sys.argv[1:]:
    model = mrcal.cameramodel(path)
    inputs = model.optimization_inputs()
    rms = []
    for optimised in (False, True):
        if optimised:
            mrcal.optimize(**inputs)
        x = mrcal.optimizer_callback(**inputs)[1]
        rms.append(float(np.sqrt((x ** 2).sum() / (inputs["observations_board"][..., 2] > 0).sum())))
    w, h = model.imagersize()
    ray = mrcal.unproject(np.array([(w - 1) / 2, (h - 1) / 2]), *model.intrinsics(), normalize=True)
    distance = float(np.median(model.optimization_inputs()["frames_rt_toref"][:, 5]))
    std = float(mrcal.projection_uncertainty(ray * distance, model, what="rms-stdev"))
    print(json.dumps([*rms, std]))
"""
"""Prints rms in each file and after mrcal.optimize(), and the standard deviation at the centre, px."""
REAL = {
    "opencv_left": "rectilinear",
    "pv_charuco_1280": "rectilinear",
    "opencv_right": "rational",
    "jy_left": "fisheye",
    "derlunz": "fisheye",
}


def simulated(model: str, f: float, d: list[float]) -> tuple[Calibration, ExportSource]:
    """Calibration of a wide lens whose views reach the corners of the image."""
    camera = Camera(model, np.array([[f, 0, 660], [0, f * 1.002, 450], [0, 0, 1]]), np.array(d), (1280, 960))
    board = Board(dictionary="DICT_4X4_1000")
    views = captured(camera, board, count=20, noise=0.15)
    found = fit(views, camera.img_size, model=model, board_shape=False)
    return found, ExportSource(found.camera, views, board)


def sources() -> Iterator[tuple[str, Calibration, ExportSource]]:
    for name in available(REAL):
        views, size = corner_views(name)
        board, _, ours = on_board(views)
        found = fit(ours, size, model=REAL[name], board_shape=False)
        yield f"{name}, {REAL[name]}", found, ExportSource(found.camera, ours, board)
    fisheye = [0.02, -0.01, 0.003, -0.001]
    yield "simulated fisheye, f 420", *simulated("fisheye", 420, fisheye)
    yield "simulated fisheye, f 560", *simulated("fisheye", 560, fisheye)
    yield "simulated omnidirectional", *simulated("omnidirectional", 900, [1.2, -0.1, 0.02, 5e-4, -5e-4])
    for model in ("rectilinear", "rational", "fisheye"):
        source = subject(model)
        found = fit(source.views, source.camera.img_size, model, board_shape=False)
        yield f"simulated {model}", found, source


def std_by_mrcals_definition(source: ExportSource) -> float:
    """Deviation at the centre, px, of the camera in the file.

    The derivative of the pixel by all unknowns, the mean over the boards of what their poses move, and the
    inverse of the whole Fisher information: https://mrcal.secretsauce.net/uncertainty.html
    """
    conversion = Mrcal().convert(source)
    camera, model = conversion.camera, models.get(conversion.camera.model)
    assert conversion.used is not None
    views = [
        View(v.object_points[m], v.image_points[m])
        for v, m in zip(source.views, conversion.used, strict=True)
        if m.sum() >= MIN_USED_POINTS
    ]
    poses = np.array(reprojection_score(camera, views).poses)
    corner = poses[:, 3:] + rotation.matrix(poses[:, :3]) @ np.array([1.0, 1.0, 0.0])
    point = center_ray(camera) * np.median(corner[:, 2])
    p, n = model.size, len(views)
    information = np.zeros((p + POSE_SIZE * n, p + POSE_SIZE * n))
    by_all = np.zeros((2, len(information)))
    _, by_k, by_point = model.jacobian(camera.intrinsics, point[:, None])
    by_all[:, :p] = by_k[:, :, 0].T
    square, count = 0.0, 0
    for i, (view, pose) in enumerate(zip(views, poses, strict=True)):
        at = slice(p + POSE_SIZE * i, p + POSE_SIZE * (i + 1))
        q, rows = linearize(
            model, camera.intrinsics, Poses.of_vectors(pose[None]), view.object_points.T[None], 0
        )
        square += float(((q[:, 0].T - view.image_points) ** 2).sum())
        count += 2 * len(view)
        flat = rows.reshape(p + POSE_SIZE, -1)
        unknowns = np.r_[0:p, at]
        information[np.ix_(unknowns, unknowns)] += flat @ flat.T
        turn = np.cross(point - pose[3:], by_point[:, :, 0].T)
        by_all[:, at] = np.concatenate([turn, by_point[:, :, 0].T], axis=1) / n
    variance = np.trace(by_all @ symmetric_inverse(information) @ by_all.T) / 2
    return float(np.sqrt(variance * square / count))


def center_ray(camera: Camera) -> Array:
    ray = camera.unproject((np.array([camera.img_size]) - 1) / 2)[0]
    unit: Array = ray / np.linalg.norm(ray)
    return unit


def in_mrcal(program: str, paths: Sequence[Path]) -> list[list[Any]]:
    """Run a program on files where mrcal is installed; return the lists that it prints."""
    command = [MRCAL_PYTHON, "-c", program, *map(str, paths)]
    run = subprocess.run(command, capture_output=True, check=True, text=True)
    return [json.loads(line) for line in run.stdout.splitlines() if line.startswith("[")]


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, found, source in sources():
            size = w, h = source.camera.img_size
            pictures = {
                "upright": transforms.identity(size),
                "turned": transforms.rotate(size, 90),
                "mirrored": transforms.mirror(size),
                "halved": transforms.resize(size, (w // 2, h // 2)),
                "cropped": transforms.crop(size, (w // 10, h // 12), (w * 3 // 4, h * 3 // 4)),
            }
            paths = []
            for kind, transform in pictures.items():
                path = Path(folder, f"{kind}.cameramodel")
                try:
                    path.write_bytes(formats.write(source, "mrcal", transform).content)
                except CalibrationError as error:  # points of a cropped picture that is refitted
                    print(name, kind, error)
                    continue
                paths.append(path)
            judged = in_mrcal(JUDGE, paths)
            change = max(before / after - 1 for before, after, _ in judged)
            same = std_by_mrcals_definition(source)
            answered = float(found.projection_std((21, 15))[7, 10]) / np.sqrt(2)  # of one axis
            stds = (judged[0][2], judged[1][2], same, answered)
            rows.append([name, f"{100 * change:.2f} %", *(f"{std:.4f}" for std in stds)])
    header = ["camera", "rms above mrcal's optimum, largest of five", "mrcal's σ at the centre, px"]
    header += ["the same, turned", "calibDB's σ of the same, px", "calibDB's σ as answered, px"]
    print(table(header, rows))


if __name__ == "__main__":
    main()
