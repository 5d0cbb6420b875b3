"""The command `board`: a board to print, or to show on a screen; and the options that describe one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..board import DICTIONARIES, KINDS, Board, opencv
from ..errors import UsageError
from ..files import write_whole
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "board", help="draw a board", description="Draw a board: as PDF in true size, or as PNG."
    )
    parser.add_argument("--pdf", metavar="FILE", help="file to print")
    parser.add_argument("--png", metavar="FILE", help="picture")
    parser.add_argument("--paper", choices=("a4", "a3", "letter"), default="a4")
    parser.add_argument(
        "--square-mm", type=float, metavar="MM", help="side of a square; the largest that fits"
    )
    add_board(parser)
    parser.set_defaults(run=run)


def add_board(parser: argparse.ArgumentParser, recognised: bool = False) -> None:
    """Add the options that describe a board; unless any is given it may be `recognised`."""
    words = "; without any of these options the board is recognised" if recognised else ""
    group = parser.add_argument_group("board", f"ChArUco, 9x6 squares, DICT_4X4_50{words}")
    group.add_argument("--kind", choices=KINDS, help="kind of board")
    group.add_argument(
        "--squares", type=options.size, metavar="CxR", help="columns and rows; of an AprilGrid its tags"
    )
    group.add_argument(
        "--marker-ratio",
        type=float,
        metavar="R",
        help="side of a marker / side of a square; of circles their diameter / distance",
    )
    group.add_argument(
        "--dictionary", choices=DICTIONARIES, metavar="DICT_…", help="OpenCV's name of the markers"
    )
    group.add_argument("--legacy", action="store_true", default=None, help="layout of OpenCV before 4.6")
    group.add_argument("--inverted", action="store_true", default=None, help="white on black")
    group.add_argument("--tag-spacing", type=float, metavar="R", help="gap between tags / side of a tag")
    group.add_argument(
        "--on-screen",
        dest="surface",
        action="store_const",
        const="screen",
        help="a screen shows the board: no bend is estimated",
    )
    if recognised:
        add_square(parser)


def add_square(parser: Any) -> None:
    """Add the option that states how large the squares are."""
    parser.add_argument("--square-mm", type=float, metavar="MM", help="side of a square, or of a tag")


def chosen_board(chosen: argparse.Namespace) -> Board | None:
    """Return the board that the options describe; None if there are none.

    Raises UsageError for one that cannot exist.
    """
    names = ("kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted", "tag_spacing", "surface")
    options = {name: value for name in names if (value := getattr(chosen, name)) is not None}
    if not options:
        return None
    if options.get("kind") == "aprilgrid":
        options.setdefault("squares", (6, 6))
    return Board(**options)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Draw the board."""
    if not (chosen.pdf or chosen.png):
        raise UsageError("say where to: --pdf board.pdf, or --png board.png")
    board = chosen_board(chosen) or Board()
    opencv()  # says what is missing before the module below is imported
    from .. import board_sheet

    if chosen.pdf:
        write_whole(Path(chosen.pdf), board_sheet.pdf(board, chosen.paper, chosen.square_mm))
        side = chosen.square_mm or board_sheet.largest_square_mm(board, chosen.paper)
        unit = "tags" if board.kind == "aprilgrid" else "squares"
        output.note(f"wrote {chosen.pdf}: print it at 100 %, {unit} have {side:g} mm")
    if chosen.png:
        write_whole(Path(chosen.png), board_sheet.png(board))
        output.note(f"wrote {chosen.png}")
    return 0
