"""The pose of an AprilTag (36h11) in a picture, by a saved calibration of any distortion model.

python apriltag_pose.py picture.png camera.json --side 0.10
"""

import argparse
import json

import cv2
import numpy as np

from calibdb_client import Calibration


def tag_poses(grey: np.ndarray, calibration: Calibration, side: float) -> list[dict[str, object]]:
    """Return the tags in a picture (h, w): id, rotation vector and translation (metres), tag to camera."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(grey)
    half = side / 2
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    poses = []
    for number, quad in zip([] if ids is None else ids.ravel().tolist(), corners, strict=True):
        # Rays instead of pixels: solvePnP need not know the lens, so that every model will do.
        rays = calibration.unproject(np.asarray(quad, dtype=np.float64).reshape(4, 2))
        plane = np.ascontiguousarray(rays[:, :2] / rays[:, 2:])
        there, rvec, tvec = cv2.solvePnP(square, plane, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
        if there:
            poses.append({"id": number, "rvec": rvec.ravel().tolist(), "tvec": tvec.ravel().tolist()})
    return poses


def main() -> int:
    """Print the poses as JSON, one tag a line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture")
    parser.add_argument("calibration", help="JSON that calibdb saved")
    parser.add_argument("--side", type=float, required=True, help="side of a tag's black square, metres")
    chosen = parser.parse_args()
    grey = cv2.imread(chosen.picture, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    if grey is None:
        parser.error(f"{chosen.picture} is not an image")
    for tag in tag_poses(grey, Calibration.load(chosen.calibration), chosen.side):
        print(json.dumps(tag))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
