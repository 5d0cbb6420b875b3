"""The command `board`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from ..board import Board, opencv
from ..errors import UsageError
from ..files import write_whole
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands, "board", run, "draw a board", "Draw a board: as PDF in true size, or as PNG."
    )
    parser.add_argument("--pdf", metavar="FILE", help="file to print")
    parser.add_argument("--png", metavar="FILE", help="picture")
    parser.add_argument("--paper", choices=("a4", "a3", "letter"), default="a4")
    parser.add_argument(
        "--square-mm", type=float, metavar="MM", help="side of a square; the largest that fits"
    )
    options.add_board(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Draw the board."""
    if not (chosen.pdf or chosen.png):
        raise UsageError("say where to: --pdf board.pdf, or --png board.png")
    board = options.chosen_board(chosen) or Board()
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
