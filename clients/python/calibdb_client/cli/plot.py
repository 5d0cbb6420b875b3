"""The command `plot`."""

from argparse import Namespace
from typing import Any

from ..board import opencv
from ..errors import UsageError
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "plot",
        run,
        "draw a report of a calibration",
        "Draw a report of a calibration that `calibdb calibrate` wrote: residuals, corners, "
        "uncertainty, poses of the board, before and after. As HTML without scripts, PNG or PDF.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` wrote")
    parser.add_argument("-o", "--output", metavar="FILE", default="report.html", help=".html, .png or .pdf")
    parser.add_argument("--picture", metavar="FILE", help="a picture of the camera, shown before and after")
    options.add_square(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Load the calibration and write the report."""
    from ..calibration import Calibration
    from ..report import write_report

    calibration = Calibration.load(chosen.file)
    write_report(chosen.output, calibration, _picture(chosen.picture, calibration.img_size), chosen.square_mm)
    output.note(f"wrote {chosen.output}")
    return 0


def _picture(path: str | None, size: tuple[int, int]) -> Any:
    if path is None:
        return None
    cv2 = opencv()
    picture = cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        raise UsageError(f"{path} cannot be read as a picture")
    if picture.shape[1::-1] != size:
        raise UsageError(f"{path} has another size than {size[0]} x {size[1]} px")
    return picture[..., ::-1]
