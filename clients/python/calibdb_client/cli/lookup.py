"""The command `lookup`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from .. import exif
from ..key import CameraKey
from ..pictures import PLATFORM
from . import options
from .output import Output, calibration_facts, estimate_facts


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "lookup",
        run,
        "look up the calibration of a camera",
        "Look up the calibration of a camera, or of a photograph's camera by its EXIF data.",
    )
    options.add_camera(parser)
    options.add_file(parser)
    options.add_service(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Look the camera up, and print what is known."""
    form = options.chosen_format(chosen)
    reported: dict[str, float] = {}
    if chosen.camera is not None and Path(chosen.camera).is_file():
        photo = exif.read(Path(chosen.camera))
        reported = photo.reported
        key = CameraKey(photo.label, PLATFORM, chosen.size or photo.size, chosen.zoom or photo.focal_mm)
    else:
        key = options.camera_key(chosen)
    with options.client(chosen) as client:
        answer = client.lookup(key, model=chosen.model, reported=reported)
        if answer.calibration is None:
            if output.json:
                document = {
                    "calibration": None,
                    "reason": answer.reason,
                    "guidance_url": answer.guidance_url,
                    "estimate": dict(answer.estimate.record) if answer.estimate else None,
                }
                output.document(document)
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
