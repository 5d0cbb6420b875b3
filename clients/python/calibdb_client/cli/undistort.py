"""The command `undistort`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from ..board import opencv
from ..calibration import Calibration
from ..errors import UsageError
from ..pictures import SUFFIXES, picture_paths
from . import options
from .output import Output, progress

DEFAULT_FRAMES_PER_SECOND = 30.0


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "undistort",
        run,
        "straighten pictures or a video",
        "Straighten pictures, folders of pictures, or a video, by a calibration.",
    )
    parser.add_argument("source", nargs="+", help="pictures, folders of pictures, or one video file")
    parser.add_argument(
        "--with", dest="calibration", required=True, metavar="FILE|ID", help="the calibration"
    )
    parser.add_argument("-o", "--output", required=True, metavar="PATH", help="file, or folder of several")
    parser.add_argument(
        "--alpha",
        type=float,
        default=0.0,
        help="0: no black pixel; 1: every pixel of the picture is kept; default 0",
    )
    options.add_service(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Read, straighten and write."""
    from ..capture.source import is_video

    opencv()
    calibration = options.calibration(chosen.calibration, chosen)
    matrix = calibration.new_camera_matrix(chosen.alpha)
    tables = calibration.remap_tables(matrix)
    target = Path(chosen.output)
    if len(chosen.source) == 1 and is_video(chosen.source[0]):
        count, what = _video(chosen.source[0], target, calibration, tables), "frames"
    else:
        count, what = _pictures(picture_paths(chosen.source), target, calibration, tables), "pictures"
    output.note(f"wrote {count} {what} to {target}")
    if output.json:
        output.document({"camera_matrix": matrix.tolist(), "written": count})
    else:
        places = ((0, 0), (1, 1), (0, 2), (1, 2))
        output.facts([("fx, fy, cx, cy", ", ".join(f"{matrix[place]:.3f}" for place in places))])
    return 0


def _pictures(paths: list[Path], target: Path, calibration: Calibration, tables: Any) -> int:
    cv2 = opencv()
    several = len(paths) > 1 or target.is_dir() or target.suffix.lower() not in SUFFIXES
    if several:
        target.mkdir(parents=True, exist_ok=True)
    with progress("pictures") as advance:
        for n, path in enumerate(paths):
            picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            if picture is None:
                raise UsageError(f"{path} cannot be read as a picture")
            straight = _straightened(str(path), picture, calibration, tables)
            to = target / path.name if several else target
            if to.exists() and to.samefile(path):
                raise UsageError(f"{path} would be replaced: give another -o")
            if not cv2.imwrite(str(to), straight):
                raise UsageError(f"{to} cannot be written")
            advance(n + 1, len(paths))
    return len(paths)


def _video(source: str, target: Path, calibration: Calibration, tables: Any) -> int:
    cv2 = opencv()
    reader = cv2.VideoCapture(source)
    rate = reader.get(cv2.CAP_PROP_FPS) or DEFAULT_FRAMES_PER_SECOND
    code = "MJPG" if target.suffix.lower() == ".avi" else "mp4v"
    writer = cv2.VideoWriter(str(target), cv2.VideoWriter.fourcc(*code), rate, calibration.img_size)
    if not writer.isOpened():
        raise UsageError(f"{target} cannot be written: give an .mp4 or .avi file")
    count = 0
    try:
        while True:
            is_there, frame = reader.read()
            if not is_there:
                break
            writer.write(_straightened(source, frame, calibration, tables))
            count += 1
    finally:
        writer.release()
        reader.release()
    if not count:
        raise UsageError(f"{source} has no frames that OpenCV reads")
    return count


def _straightened(name: str, picture: Any, calibration: Calibration, tables: Any) -> Any:
    h, w = picture.shape[:2]
    if (w, h) != calibration.img_size:
        width, height = calibration.img_size
        raise UsageError(f"{name} has {w} x {h} px, the calibration is of {width} x {height}")
    return opencv().remap(picture, *tables, opencv().INTER_LINEAR)
