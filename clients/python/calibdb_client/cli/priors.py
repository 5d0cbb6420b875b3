"""The command `priors`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from .. import priors
from ..files import ExportedFile
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "priors",
        run,
        "cameras of a folder of photographs, for COLMAP and others",
        "Look up the cameras of a folder of photographs by their EXIF data, and write them for a "
        "program that reconstructs from them: calibrated, or else estimated.",
    )
    parser.add_argument("folder", type=Path, help="folder of photographs")
    parser.add_argument("--format", choices=priors.WRITERS, default="colmap", help="program (colmap)")
    options.add_lookup_model(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="write the file there")
    options.add_service(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Look the cameras up, and write them."""
    photographs = priors.photographs(chosen.folder)
    with options.client(chosen) as client:
        groups = priors.look_up(
            photographs, lambda key, reported: client.lookup(key, model=chosen.model, reported=reported)
        )
    for group in groups:
        output.note(group.title)
    content = priors.WRITERS[chosen.format](groups)
    output.file(ExportedFile(content.encode(), f"priors.{chosen.format}", "text/plain"), chosen.output)
    return 0
