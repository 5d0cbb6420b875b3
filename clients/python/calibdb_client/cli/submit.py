"""The command `submit`: corners that were kept in a file become a calibration."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..key import UNNAMED
from ..pictures import PLATFORM
from ..recording import Recording
from . import options
from .board import add_square
from .calibrate import finish
from .capture_options import add_fix, add_licence, add_mode_name, add_model, add_offline, fix_of, licence_of
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "submit",
        help="send the corners that `calibrate` kept",
        description="Send the corners in a file that `calibdb calibrate` wrote, or calibrate them again.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` wrote")
    parser.add_argument("--label", help="label of the camera, if another one than the file's")
    parser.add_argument("--platform", help=f"its platform, if not the file's ({PLATFORM})")
    add_offline(parser)
    add_model(parser)
    add_square(parser)
    add_fix(parser)
    add_licence(parser)
    add_mode_name(parser)
    options.add_service(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Read the file and calibrate."""
    fix_of(chosen)  # refused before anything is read
    path = Path(chosen.file)
    recording = Recording.load(path)
    if not (chosen.offline or chosen.label) and recording.key.camera == UNNAMED:
        raise UsageError("which camera took the pictures? Say --label, and --platform if a browser used it")
    chosen.licence = None if chosen.offline else licence_of(chosen, output)
    key = replace(
        recording.key,
        camera=chosen.label or recording.key.camera,
        platform=chosen.platform or recording.key.platform,
    )
    return finish(replace(recording, key=key), path, chosen, output)
