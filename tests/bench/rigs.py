"""`make bench DOCS=rigs RIGS=200`: errors of simulated rigs, predicted and true, and guided captures."""

import os
from collections.abc import Sequence

import numpy as np

from calibsolver import Board, CalibrationError, Camera, View, rig
from calibsolver.rig.start import RigidMotion
from calibsolver.rotation import matrix
from tests.bench.document import table
from tests.helpers.solver import rigs, synthetic

RIGS = int(os.environ.get("RIGS", "200"))
BOARD = Board((9, 6))
NOISE = 0.2  # px
GOAL = 0.3  # px
MAX_MOMENTS = 30
MIN_MOMENTS = 4
SQUARE_CM = 3.0


def draw(kind: str, rng: np.random.Generator) -> tuple[rigs.Rig, int]:
    """Rig of a kind, and the number of moments that it is fitted to."""
    flat, wide = synthetic.rectilinear_cameras(12), synthetic.fisheye_cameras(12)

    def pick(many: Sequence[Camera]) -> Camera:
        return many[int(rng.integers(len(many)))]

    if kind == "two webcams":
        return rigs.side_by_side([pick(flat), pick(flat)], rng.uniform(1, 4)), 8
    if kind == "two fisheyes":
        return rigs.side_by_side([pick(wide), pick(wide)], rng.uniform(1, 4)), 8
    if kind == "three, mixed":
        return rigs.side_by_side([pick(flat), pick(wide), pick(flat)], rng.uniform(1, 3)), 10
    return rigs.ring([pick(wide if i % 2 else flat) for i in range(8)], 2.0), 24


def as_rig(found: rig.RigCalibration) -> rigs.Rig:
    return rigs.Rig(found.cameras, [RigidMotion.of_vector(pose) for pose in found.poses])


def formats(truth: rigs.Rig) -> list[tuple[tuple[int, int], str]]:
    return [(camera.img_size, camera.model) for camera in truth.cameras]


def predicted(kind: str, count: int) -> list[str]:
    """Row of true and predicted errors."""
    errors, expected = [], []
    for seed in range(count):
        rng = np.random.default_rng(seed)
        truth, moments = draw(kind, rng)
        found = rig.fit(rigs.moments(truth, BOARD, moments, NOISE, rng), formats(truth))
        errors.append(rigs.transfer_error(truth, as_rig(found), found.working_distances.tolist()))
        expected.append(found.uncertainty.rms)
    ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(expected)))
    return [kind, str(count), f"{np.median(errors):.3f}", f"{ratio:.2f}"]


def webcams(rng: np.random.Generator) -> rigs.Rig:
    """Two webcams 6 to 60 cm apart, their axes parallel or meeting from 0.7 m on."""
    flat = synthetic.rectilinear_cameras(12)
    baseline = float(np.exp(rng.uniform(np.log(6), np.log(60))) / SQUARE_CM)
    turn = -baseline * SQUARE_CM / 70 * rng.uniform(0, 1)
    other = rigs.placed(
        (baseline, rng.normal(0, 0.3), rng.normal(0, 0.3)), (*rng.normal(0, 0.02, 1), turn, 0.01)
    )
    return rigs.Rig(
        [flat[int(rng.integers(12))], flat[int(rng.integers(12))]],
        [RigidMotion(np.eye(3), np.zeros(3)), other],
    )


def capture(truth: rigs.Rig, rng: np.random.Generator) -> tuple[int, float, float]:
    """Capture under guidance: moments taken (MAX_MOMENTS + 1 where stuck), predicted and true error, px."""
    cameras = formats(truth)
    moments: list[dict[int, View]] = []
    calibration: rig.RigCalibration | None = None
    user = synthetic.User()
    skipped: list[np.ndarray] = []
    tries = missed = 0
    while len(moments) < MAX_MOMENTS and tries < 3 * MAX_MOMENTS:
        tries += 1
        target = rig.next_moment(BOARD, cameras, moments, calibration, skipped, missed)
        lead = max(target.views, key=lambda i: len(target.views[i].ids))
        held = target.views[lead]
        if calibration is not None:
            held = synthetic.match_picture(BOARD, calibration.cameras[lead], truth.cameras[lead], held)
        rvec, tvec = user.hold(BOARD, held, rng)
        pose = truth.motions[lead].inverse() @ RigidMotion(matrix(rvec), tvec)
        moment = truth.see(BOARD, pose, NOISE, rng)
        if len(moment) < (2 if target.pose is None else 1):
            missed += 1
            if target.pose is not None:
                skipped.append(target.pose)
            continue
        moments.append(moment)
        skipped, missed = [], 0
        try:
            calibration = rig.fit(moments, cameras)
        except CalibrationError:
            calibration = None
            continue
        if len(moments) >= MIN_MOMENTS and calibration.uncertainty.rms <= GOAL:
            error = rigs.transfer_error(truth, as_rig(calibration), calibration.working_distances.tolist())
            return len(moments), calibration.uncertainty.rms, error
    return MAX_MOMENTS + 1, np.nan, np.nan


def closed_loop(count: int) -> list[str]:
    """Row of the moments that guided captures of two webcams take, and their errors."""
    taken = []
    for seed in range(count):
        rng = np.random.default_rng(1000 + seed)
        taken.append(capture(webcams(rng), rng))
    numbers, _, errors = np.array(taken).T
    views = [f"{np.median(numbers):.0f}", f"{np.percentile(numbers, 95):.0f}"]
    stuck = str((numbers > MAX_MOMENTS).sum())
    return [str(count), *views, stuck, f"{np.nanmedian(errors):.3f}", f"{np.nanpercentile(errors, 95):.3f}"]


def late(count: int, moments: int) -> list[str]:
    """Row of views that are 200 ms late, the hand at 5 cm/s: how many are set aside, and how many others."""
    caught = wrong = tried = 0
    for seed in range(count):
        rng = np.random.default_rng(2000 + seed)
        truth = webcams(rng)
        try:
            good = rigs.moments(truth, BOARD, moments, NOISE, rng)
            moment = rigs.late_moment(truth, BOARD, 0.2 * 5 / SQUARE_CM, NOISE, rng)
        except ValueError:
            continue
        found = rig.fit([*good, moment], formats(truth))
        aside = {m for m, _ in found.set_aside}
        tried, caught, wrong = tried + 1, caught + (moments in aside), wrong + bool(aside - {moments})
    return list(map(str, (moments, tried, caught, wrong)))


def main() -> None:
    rows = [predicted(kind, RIGS) for kind in ("two webcams", "two fisheyes", "three, mixed")]
    rows.append(predicted("eight in a ring", max(RIGS // 4, 1)))
    print(table(["rig", "rigs", "true error, px, median", "true / predicted, rms"], rows), "\n")
    header = ["captures", "moments, median", "95 %", "stuck", "true error, px, median", "95 %"]
    print(table(header, [closed_loop(RIGS)]), "\n")
    header = ["good moments", "rigs with a late one", "set aside", "rigs with another set aside"]
    print(table(header, [late(RIGS, moments) for moments in (4, 6, 8)]))


if __name__ == "__main__":
    main()
