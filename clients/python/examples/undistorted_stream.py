"""A rectified video of a camera, a stream or a file.

python undistorted_stream.py input.avi camera.json output.avi --alpha 0 --frames 300
"""

import argparse

import cv2

from calibdb_client import Calibration, UsageError


def main() -> int:
    """Read, rectify, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", help="index of a camera, address of a stream, or file")
    parser.add_argument("calibration", help="JSON that calibdb saved")
    parser.add_argument("output")
    parser.add_argument("--alpha", type=float, default=0.0, help="0: no black pixel; 1: the whole picture")
    parser.add_argument("--frames", type=int, default=0, help="stop after so many; 0: at the end")
    chosen = parser.parse_args()
    calibration = Calibration.load(chosen.calibration)
    source = cv2.VideoCapture(int(chosen.source) if chosen.source.isdigit() else chosen.source)
    # The tables are computed once; each frame is then one cv2.remap.
    matrix = calibration.new_camera_matrix(chosen.alpha)
    tables = calibration.remap_tables(matrix)
    writer = None
    count = 0
    while not chosen.frames or count < chosen.frames:
        there, frame = source.read()
        if not there:
            break
        h, w = frame.shape[:2]
        if (w, h) != calibration.img_size:
            raise UsageError(f"the frames have {w}x{h} px: look the camera up at that size")
        if writer is None:
            rate = source.get(cv2.CAP_PROP_FPS) or 30.0
            writer = cv2.VideoWriter(chosen.output, cv2.VideoWriter.fourcc(*"MJPG"), rate, (w, h))
        writer.write(cv2.remap(frame, *tables, cv2.INTER_LINEAR))
        count += 1
    source.release()
    if writer is not None:
        writer.release()
    print(f"{count} frames, camera matrix {matrix.round(2).tolist()}")
    return 0 if count else 1


if __name__ == "__main__":
    raise SystemExit(main())
