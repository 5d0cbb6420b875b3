"""The command `lookup`: the calibration of a camera."""

from __future__ import annotations

import argparse
from typing import Any

from ..export_query import FORMATS
from . import options
from .output import Output, calibration_facts


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "lookup",
        help="look up the calibration of a camera",
        description="Look up the calibration of a camera.",
    )
    options.add_camera(parser)
    parser.add_argument("--format", choices=FORMATS, help="print another tool's file")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the file there")
    options.add_service(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Look the camera up, and print what is known."""
    key = options.camera_key(chosen)
    with options.client(chosen) as client:
        answer = client.lookup(key, model=chosen.model)
        if answer.calibration is None:
            if output.json:
                output.document(
                    {"calibration": None, "reason": answer.reason, "guidance_url": answer.guidance_url}
                )
            output.note(f"{key.camera}, {key.img_size[0]}x{key.img_size[1]}: {answer.detail}")
            output.note(f"calibrate it in a browser: {answer.guidance_url}")
            return 1
        if chosen.format or chosen.output:
            output.file(answer.calibration.export(chosen.format or "calibdb"), chosen.output)
        elif output.json:
            output.document(dict(answer.calibration.record))
        else:
            output.facts(calibration_facts(answer.calibration.record))
    return 0
