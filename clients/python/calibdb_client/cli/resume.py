"""The command `resume`: continue a live capture that ended early."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import UsageError
from ..key import UNNAMED
from ..recording import Recording
from . import live, options
from .capture_options import add_licence, add_mode_name, add_model, add_offline, add_show, licence_of
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "resume",
        help="continue a live capture that ended early",
        description="Continue a live capture, from the file that `calibdb calibrate` kept.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` kept")
    parser.add_argument("camera", nargs="?", help="the camera; found by its label unless given")
    add_offline(parser)
    add_show(parser)
    add_model(parser)
    add_licence(parser)
    add_mode_name(parser)
    options.add_service(parser)
    parser.set_defaults(run=run, square_mm=None)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Read the file, open the camera, and continue the capture."""
    recording = Recording.load(chosen.file)
    if not recording.live:
        raise UsageError(f"{chosen.file} contains images, not a live capture: `calibdb submit {chosen.file}`")
    if not chosen.offline and recording.key.camera == UNNAMED:
        raise UsageError("this capture has no camera's label: go on with --offline")
    camera = chosen.camera or recording.key.camera
    if camera == UNNAMED:
        raise UsageError("which camera is it? Give its index, path or address after the file")
    licence = None if chosen.offline else licence_of(chosen, output)
    arguments = {"resume": recording, "show": chosen.show}
    return live.capture(camera, arguments, licence, live.KeptFile(chosen.file), chosen, output)
