"""The command `plot`: a report of a calibration with its corners."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import UsageError
from .board import add_square
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "plot",
        help="draw a report of a calibration",
        description="Draw a report of a calibration that `calibdb calibrate` wrote: residuals, corners, "
        "uncertainty, poses of the board, before and after. As HTML without scripts, PNG or PDF.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` wrote")
    parser.add_argument("-o", "--output", metavar="FILE", default="report.html", help=".html, .png or .pdf")
    parser.add_argument("--picture", metavar="FILE", help="a picture of the camera, shown before and after")
    add_square(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
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
    from ..board import opencv

    cv2 = opencv()
    picture = cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        raise UsageError(f"{path} cannot be read as a picture")
    if picture.shape[1::-1] != size:
        raise UsageError(f"{path} has another size than {size[0]} x {size[1]} px")
    return picture[..., ::-1]
