"""Estimate of a running rig in plain values."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from .. import deadline
from ..board import Board
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.uncertainty import square_errors
from ..guidance.hints import Hint, Placement, largest_difference
from ..guidance.target import TargetPose
from .calibration import RigCalibration
from .fit import fit, held_out_rms
from .guidance import RigTarget, next_moment
from .problem import MAX_ONLINE_POINTS, Moment, thin, unlinked_cameras
from .start import RigidMotion

UNCERTAINTY_GRID = (20, 15)
MAX_HELD_OUT_S = 1.0
MAX_HELD_OUT_POINTS = 4_000
"""Limits of the cross-validation of a rig that ends."""


@dataclass(frozen=True, eq=False)
class _Rig:
    """Cameras that are there, of `count`, and what they saw. `positions` are those of the whole rig."""

    board: Board
    positions: Sequence[int]
    count: int
    cameras: Sequence[tuple[tuple[int, int], str]]
    starts: Mapping[int, Camera]
    names: Sequence[str]
    moments: Sequence[Moment]

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "_Rig":
        board = Board.from_record(record["board"])
        records = record["cameras"]
        positions = [i for i, camera in enumerate(records) if camera is not None]
        number = {position: n for n, position in enumerate(positions)}
        there = [records[position] for position in positions]
        return cls(
            board,
            positions,
            len(records),
            [(tuple(camera["img_size"]), camera["distortion_model"]) for camera in there],
            {n: Camera.from_record(camera["start"]) for n, camera in enumerate(there) if camera["start"]},
            [moment["id"] for moment in record["moments"]],
            [
                {
                    number[p]: board.view(record_of_view["ids"], record_of_view["points"])
                    for p, record_of_view in moment["views"].items()
                }
                for moment in record["moments"]
            ],
        )


def estimate(record: Mapping[str, Any], *, final: bool = False) -> dict[str, Any]:
    """Fit a rig to its moments, and choose the next one, or with `final` cross-validate the fit.

    Parameters
    ----------
    record
        `board`; `cameras`: by position `img_size`, `distortion_model` and `start` (a calibration record that
        may be near, or None), or None if no camera is there yet; `moments`: `id` and `views`, position ->
        `ids`, `points`; `skipped`: poses (6,) not wanted; `missed`: targets without a pose given up.

    Returns
    -------
    dict
        `fit` or None, and `problem` why; `unlinked`: positions that share no moment with camera 0; `target`
        and `target_pose`, board -> camera 0. Lengths are in board units.
    """
    rig = _Rig.from_record(record)
    lost = {rig.positions[n] for n in unlinked_cameras(len(rig.positions), rig.moments)}
    lost |= set(range(rig.count)) - set(rig.positions)
    calibration, problem = None, None
    if not lost and rig.moments:
        try:
            calibration = fit(rig.moments, rig.cameras, starts=rig.starts, max_points=MAX_ONLINE_POINTS)
        except CalibrationError as error:
            problem = error.message
        if calibration is not None and not _is_determined(calibration):
            calibration, problem = None, "the views leave it undetermined"
    fitted = None if calibration is None else _fit_record(rig, calibration)
    result: dict[str, Any] = {"fit": fitted, "problem": problem, "unlinked": sorted(lost)}
    if final:
        if fitted is not None and calibration is not None:
            moments = thin(rig.moments, MAX_HELD_OUT_POINTS)
            cross_validate = partial(held_out_rms, moments, calibration)
            fitted["held_out_rms"] = deadline.compute_within(MAX_HELD_OUT_S, cross_validate, None)
        return result
    if not rig.positions:
        return result
    skipped = [np.asarray(pose, dtype=np.float64) for pose in record["skipped"]]
    try:
        target = next_moment(rig.board, rig.cameras, rig.moments, calibration, skipped, record["missed"])
    except CalibrationError:  # a capture continues without a target
        target = RigTarget(None, {}, "")
    return {
        **result,
        "target": _target_record(rig, target, calibration),
        "target_pose": None if target.pose is None else target.pose.tolist(),
    }


def _is_determined(calibration: RigCalibration) -> bool:
    numbers = (
        np.array([calibration.rms, *astuple(calibration.uncertainty)]),
        calibration.covariance,
        calibration.poses,
        *(camera.intrinsics for camera in calibration.cameras),
    )
    return all(bool(np.isfinite(each).all()) for each in numbers)


def _fit_record(rig: _Rig, calibration: RigCalibration) -> dict[str, Any]:
    shape, positions = calibration.board_shape, range(rig.count)
    variances = [np.diagonal(calibration.pose_covariance(i)) for i in positions]
    return {
        "cameras": [_camera_record(rig, calibration, i) for i in positions],
        "poses": calibration.poses.tolist(),
        "std": [np.sqrt(np.maximum(each, 0)).tolist() for each in variances],
        "rms": calibration.rms,
        "uncertainty": asdict(calibration.uncertainty),
        "set_aside": [
            {"moment": rig.names[m], "position": i, "reason": reason}
            for (m, i), reason in sorted(calibration.set_aside.items())
        ],
        "board_poses": [
            {"moment": name, "pose": pose.tolist()}
            for name, pose in zip(rig.names, calibration.board_poses, strict=True)
            if np.isfinite(pose).all()
        ],
        "turned": [{"moment": rig.names[m], "position": i} for m, i in calibration.turned],
        **({} if shape is None else {"board_shape": shape.figures()}),
    }


def _camera_record(rig: _Rig, calibration: RigCalibration, position: int) -> dict[str, Any]:
    camera = calibration.cameras[position]
    square = square_errors(camera, calibration.intrinsics_covariance(position), UNCERTAINTY_GRID)
    square = square[np.isfinite(square)]
    if not square.size:
        square = np.array([float(max(camera.img_size)) ** 2])
    counted = [
        (error, len(rig.moments[m][i]))
        for (m, i), error in calibration.view_errors.items()
        if i == position and (m, i) not in calibration.set_aside and np.isfinite(error)
    ]
    points = sum(n for _, n in counted)
    return {
        **camera.record(),
        "avg_reprojection_error": float(np.sqrt(sum(e**2 * n for e, n in counted) / max(points, 1))),
        "uncertainty": {"rms": float(np.sqrt(square.mean())), "max": float(np.sqrt(square.max()))},
        "systematic": calibration.inflation,
    }


def _target_record(rig: _Rig, target: RigTarget, calibration: RigCalibration | None) -> dict[str, Any] | None:
    if not target.views:
        return None
    cameras = []
    for n, view in sorted(target.views.items()):
        hint = _hint(rig, view, n, calibration)
        hinted = replace(view, hint=hint.text, hint_code=hint.code).to_dict()
        members = {name: value for name, value in hinted.items() if name not in ("purpose", "gain")}
        cameras.append({"position": rig.positions[n], **members})
    return {
        "purpose": target.purpose,
        "hint": cameras[0]["hint"],
        "hint_code": cameras[0]["hint_code"],
        "cameras": cameras,
    }


def _hint(rig: _Rig, target: TargetPose, number: int, calibration: RigCalibration | None) -> Hint:
    if calibration is None:
        return Hint(target.hint_code)
    poses = [pose for pose in calibration.board_poses if np.isfinite(pose).all()]
    if not poses:
        return Hint(target.hint_code)
    camera = calibration.cameras[number]
    last = calibration.motions[number] @ RigidMotion.of_vector(poses[-1])
    return largest_difference(
        Placement.of(rig.board, camera, last.r, last.t),
        Placement.of(rig.board, camera, target.r, target.tvec),
        camera.img_size[0],
    )
