"""PhotonVision's calibration JSON, the keypoints among it."""

from typing import Any

import numpy as np

from .. import models, rotation
from ..arrays import Array, Mask
from ..errors import CalibrationError
from ..fitting import resection
from ..view import View
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv
from .format import Format

VIEWS, POINTS = 1000, 10_000


class PhotonVision(Format):
    """OpenCV's matrices as flat JSON; `observations` hold what was seen. Board lengths are in squares."""

    name = "photonvision"
    suffix = ".json"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        board = source.board.squares if source.board else (0, 0)
        return text.dump(
            {
                "resolution": {"width": float(c.img_size[0]), "height": float(c.img_size[1])},
                "cameraIntrinsics": _matrix(c.matrix),
                "distCoeffs": _matrix(c.distortion[None]),
                "calobjectWarp": [0.0, 0.0],
                "observations": self._observations(source, conversion),
                "calobjectSize": {"width": float(board[0]), "height": float(board[1])},
                "calobjectSpacing": 1.0,
                "lensmodel": "LENSMODEL_OPENCV",
            },
            conversion.warning,
        )

    @staticmethod
    def _observations(source: ExportSource, conversion: Conversion) -> list[dict[str, Any]]:
        if not source.views:
            return []
        found, camera = [], conversion.camera
        poses = resection.reprojection_score(camera, source.views).poses
        for i, (view, rt) in enumerate(zip(source.views, poses, strict=True)):
            is_posed = bool(np.isfinite(rt).all())  # points on a line may have no pose
            rt = rt if is_posed else np.array([0, 0, 0, 0, 0, 1.0])
            r = rotation.matrix(rt[None, :3])[0]
            # the bare formula: a corner may lie just beyond where the model is one-to-one
            seen = (
                models.get(camera.model).project(camera.intrinsics, r @ view.object_points.T + rt[3:, None]).T
            )
            residuals = seen - view.image_points if is_posed else np.zeros_like(view.image_points)
            found.append(
                {
                    "locationInObjectSpace": [_point(p) for p in view.object_points],
                    "locationInImageSpace": [_point(q) for q in view.image_points],
                    "reprojectionErrors": [_point(e) for e in residuals],
                    "optimisedCameraToObject": {
                        "translation": _point(rt[3:]),
                        "rotation": {"quaternion": _point(quaternion(rt[:3]), "WXYZ")},
                    },
                    "cornersUsed": [True] * len(view),
                    "snapshotName": f"{source.name}, view {i}",
                    "snapshotDataLocation": "",
                }
            )
        return found


def _matrix(m: Array) -> dict[str, object]:
    return {"rows": m.shape[0], "cols": m.shape[1], "type": 6, "data": m.ravel().tolist()}


def _point(p: Array, names: str = "xyz") -> dict[str, float]:
    return dict(zip(names, p.tolist(), strict=False))


def quaternion(rvec: Array) -> Array:
    """Convert a rotation vector (3,) to a unit quaternion (w, x, y, z)."""
    angle = float(np.linalg.norm(rvec))
    axis = rvec / angle if angle > 0 else np.zeros(3)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])


def read(data: object) -> ImportedFile:
    """Read a parsed file; CalibrationError ``malformed``."""
    names = ("resolution.width", "resolution.height")
    size = text.width_height((text.member(data, *name.split(".")) for name in names), names)
    k = text.floats(text.member(data, "cameraIntrinsics", "data"), "cameraIntrinsics", 9, 9).reshape(3, 3)
    key = "distCoeffs" if isinstance(data, dict) and "distCoeffs" in data else "cameraExtrinsics"
    d = text.floats(text.member(data, key, "data"), key, 0, 14)
    seen = data.get("observations", []) if isinstance(data, dict) else []
    if not isinstance(seen, list) or len(seen) > VIEWS:
        raise text.refuse(f"observations must be a list of at most {VIEWS}")
    views = [view for view in (_view(item) for item in seen) if len(view)]
    return ImportedFile(camera_from_opencv(k, d, size, fisheye=False), tuple(views))


def _view(item: object) -> View:
    p = _points(text.member(item, "locationInObjectSpace"), "xyz")
    q = _points(text.member(item, "locationInImageSpace"), "xy")
    used = item.get("cornersUsed") if isinstance(item, dict) else None
    try:
        view = View(p, q)
    except ValueError as error:
        raise text.refuse(f"an observation makes no sense: {error}") from None
    # Corners that were not seen are written as negative pixels.
    keep: Mask = np.asarray((q >= -0.5).all(axis=1))
    if isinstance(used, list) and len(used) == len(p):
        keep &= np.array([bool(flag) for flag in used])
    return view.subset(keep)


def _points(items: object, axes: str) -> Array:
    if not isinstance(items, list) or len(items) > POINTS:
        raise text.refuse(f"an observation must be a list of at most {POINTS} points")
    flat = text.floats([[text.member(item, axis) for axis in axes] for item in items], "an observation")
    if len(flat) != len(items) * len(axes):
        raise CalibrationError("malformed", "an observation has points of too many numbers")
    return flat.reshape(-1, len(axes))
