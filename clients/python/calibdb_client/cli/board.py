"""The command `board`: a board to print, or to show on a screen."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..board import DICTIONARIES, Board
from ..errors import UsageError
from . import options
from .output import Output, write_whole


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "board", help="draw a board", description="Draw a ChArUco board: as PDF in true size, or as PNG."
    )
    parser.add_argument("--pdf", metavar="FILE", help="file to print")
    parser.add_argument("--png", metavar="FILE", help="picture")
    parser.add_argument("--paper", choices=("a4", "a3", "letter"), default="a4")
    parser.add_argument(
        "--square-mm", type=float, metavar="MM", help="side of a square; the largest that fits"
    )
    add_board(parser)
    parser.set_defaults(run=run)


def add_board(parser: argparse.ArgumentParser) -> None:
    """Add the options that describe a board."""
    usual = Board()
    parser.add_argument("--squares", type=options.size, default=usual.squares, metavar="CxR")
    parser.add_argument("--marker-ratio", type=float, default=usual.marker_ratio, metavar="R")
    parser.add_argument("--dictionary", choices=DICTIONARIES, default=usual.dictionary, metavar="DICT_…")
    parser.add_argument("--legacy", action="store_true", help="layout of OpenCV before 4.6")


def chosen_board(chosen: argparse.Namespace) -> Board:
    """Return the board that the options describe. Raises UsageError for one that cannot exist."""
    return Board(chosen.squares, chosen.marker_ratio, chosen.dictionary, chosen.legacy)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Draw the board."""
    if not (chosen.pdf or chosen.png):
        raise UsageError("say where to: --pdf board.pdf, or --png board.png")
    board = chosen_board(chosen)
    board.opencv()  # says what is missing before the module below is imported
    from .. import board_sheet

    if chosen.pdf:
        write_whole(Path(chosen.pdf), board_sheet.pdf(board, chosen.paper, chosen.square_mm))
        side = chosen.square_mm or board_sheet.largest_square_mm(board, chosen.paper)
        output.note(f"wrote {chosen.pdf}: print it at 100 %, squares have {side:g} mm")
    if chosen.png:
        write_whole(Path(chosen.png), board_sheet.png(board))
        output.note(f"wrote {chosen.png}")
    return 0
