"""The command `lookup`: the calibration of a camera."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .. import exif
from ..key import CameraKey
from ..pictures import PLATFORM
from . import options
from .output import Output, calibration_facts, estimate_facts


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "lookup",
        help="look up the calibration of a camera",
        description="Look up the calibration of a camera, or of a photograph's camera by its EXIF data.",
    )
    options.add_camera(parser)
    options.add_file(parser)
    options.add_service(parser)
    parser.set_defaults(run=run)


def _key(chosen: argparse.Namespace) -> tuple[CameraKey, dict[str, float]]:
    """Return the camera of the options or of a photograph, and the focal length that its EXIF data report."""
    if chosen.camera is None or not Path(chosen.camera).is_file():
        return options.camera_key(chosen), {}
    photo = exif.read(Path(chosen.camera))
    key = CameraKey(photo.label, PLATFORM, chosen.size or photo.size, chosen.zoom or photo.focal_mm)
    return key, photo.reported


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Look the camera up, and print what is known."""
    form = options.chosen_format(chosen)
    key, reported = _key(chosen)
    with options.client(chosen) as client:
        answer = client.lookup(key, model=chosen.model, reported=reported)
        if answer.calibration is None:
            if output.json:
                likely = dict(answer.estimate.record) if answer.estimate else None
                output.document(
                    {
                        "calibration": None,
                        "reason": answer.reason,
                        "guidance_url": answer.guidance_url,
                        "estimate": likely,
                    }
                )
            elif answer.estimate is not None:
                output.facts(estimate_facts(answer.estimate.record))
            output.note(f"{key.camera}, {key.img_size[0]}x{key.img_size[1]}: {answer.detail}")
            output.note(f"calibrate it in a browser: {answer.guidance_url}")
            return 1
        if chosen.format or chosen.output:
            output.file(answer.calibration.export(form), chosen.output)
        elif output.json:
            output.document(dict(answer.calibration.record))
        else:
            output.facts(calibration_facts(answer.calibration.record))
    return 0
