"""The command `export`: a stored calibration as another tool's file."""

from __future__ import annotations

import argparse
from typing import Any

from ..export_query import FORMATS
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "export",
        help="write a calibration as another tool's file",
        description="Write a calibration as another tool's file.",
    )
    parser.add_argument("id", help="id of the calibration or consensus")
    parser.add_argument("--format", choices=FORMATS, default="calibdb")
    parser.add_argument("-o", "--output", metavar="FILE", help="file; standard output unless given")
    parser.add_argument("--crop", type=_numbers, metavar="L,T,W,H", help="part that is cut out first, px")
    parser.add_argument("--resize", type=options.size, metavar="WxH", help="size to which it is then scaled")
    parser.add_argument("--rotate", type=int, choices=(0, 90, 180, 270), default=0, help="degrees clockwise")
    parser.add_argument("--mirror", action="store_true", help="swap left and right at last")
    options.add_service(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Fetch the file and write it."""
    with options.client(chosen) as client:
        file = client.export(
            chosen.id,
            chosen.format,
            crop=chosen.crop,
            resize=chosen.resize,
            rotate=chosen.rotate,
            mirror=chosen.mirror,
        )
    output.file(file, chosen.output)
    return 0


def _numbers(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError("four whole numbers with commas: left,top,width,height") from None
