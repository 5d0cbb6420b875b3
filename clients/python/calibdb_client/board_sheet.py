"""A board on paper (PDF, in true size) or as a picture (PNG)."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import numpy as np

from .board import Board
from .errors import UsageError

PAPERS_MM = {"a4": (297.0, 210.0), "a3": (420.0, 297.0), "letter": (279.4, 215.9)}
"""Width and height of the sheets, lying, mm."""
MARGIN_MM = 10.0
MAX_PNG_PX = 8192
_POINTS_PER_MM = 72 / 25.4
Rectangle = tuple[float, float, float, float]


def largest_square_mm(board: Board, paper: str) -> float:
    """Return the side of the largest square, in whole half millimetres, with which the board fits a sheet."""
    (w, h), (columns, rows) = _sheet(board, paper), board.squares
    side = min((w - 2 * MARGIN_MM) / columns, (h - 3 * MARGIN_MM) / rows)
    return int(side * 2) / 2


def pdf(board: Board, paper: str = "a4", square_mm: float | None = None) -> bytes:
    """Return a page with the board in true size, and a line that says what it is.

    Raises UsageError if the board does not fit the sheet.
    """
    largest = largest_square_mm(board, paper)
    side = square_mm or largest
    if not 1 <= side <= largest:
        raise UsageError(f"on {paper} a square of this board has 1 to {largest:g} mm, not {side:g}")
    w, h = _sheet(board, paper)
    left, top = (w - side * board.squares[0]) / 2, (h - MARGIN_MM - side * board.squares[1]) / 2
    drawn = "\n".join(
        f"{_pt(left + side * x):.4f} {_pt(h - top - side * (y + b)):.4f} {_pt(side * a):.4f} "
        f"{_pt(side * b):.4f} re"
        for x, y, a, b in black(board)
    )
    said = (
        f"calibDB board: {board.squares[0]} x {board.squares[1]} squares of {side:g} mm, "
        f"marker ratio {board.marker_ratio:g}, {board.dictionary}{', legacy' if board.legacy else ''}. "
        "Print at 100 %, and glue it to something flat."
    )
    text = f"BT /F1 8 Tf {_pt(MARGIN_MM):.2f} {_pt(MARGIN_MM / 2):.2f} Td ({said}) Tj ET"
    return _document(_pt(w), _pt(h), f"0 g\n{drawn}\nf\n{text}\n")


def png(board: Board, square_px: int = 120) -> bytes:
    """Return a picture of the board with a margin of half a square.

    Raises UsageError for a size that is too small or too large.
    """
    import cv2

    w, h = (square_px * (n + 1) for n in board.squares)
    if not square_px >= 16 or max(w, h) > MAX_PNG_PX:
        raise UsageError(f"squares have 16 px or more, the picture at most {MAX_PNG_PX} px, not {w} x {h}")
    picture = board.opencv().generateImage((w, h), marginSize=square_px // 2, borderBits=1)
    _, encoded = cv2.imencode(".png", picture)
    return bytes(encoded)


def black(board: Board) -> Iterator[Rectangle]:
    """Yield what is black: left, top, width, height in squares, y down; squares, then markers."""
    import cv2

    drawn: Any = board.opencv()
    places = [np.asarray(corners)[:, :2] for corners in drawn.getObjPoints()]
    with_marker = {tuple(np.floor(place.mean(axis=0)).astype(int).tolist()) for place in places}
    columns, rows = board.squares
    for y in range(rows):
        for x in range(columns):
            if (x, y) not in with_marker:
                yield x, y, 1.0, 1.0
    dictionary = drawn.getDictionary()
    cells = dictionary.markerSize + 2
    for identifier, place in zip(drawn.getIds().ravel().tolist(), places, strict=True):
        picture = cv2.aruco.generateImageMarker(dictionary, int(identifier), cells, borderBits=1)
        (left, top), cell = place.min(axis=0).tolist(), board.marker_ratio / cells
        for row, line in enumerate(picture < 128):
            yield from _runs(line.tolist(), left, top + row * cell, cell)


def _runs(line: list[bool], left: float, top: float, cell: float) -> Iterator[Rectangle]:
    """Yield the runs of black cells in one row of a marker: in one piece, without hairlines."""
    start = None
    for column, is_black in enumerate([*line, False]):
        if is_black and start is None:
            start = column
        elif not is_black and start is not None:
            yield left + start * cell, top, (column - start) * cell, cell
            start = None


def _sheet(board: Board, paper: str) -> tuple[float, float]:
    if paper not in PAPERS_MM:
        raise UsageError(f"a sheet is one of {', '.join(PAPERS_MM)}, not {paper!r}")
    w, h = PAPERS_MM[paper]
    return (w, h) if board.squares[0] >= board.squares[1] else (h, w)


def _pt(millimetres: float) -> float:
    return millimetres * _POINTS_PER_MM


def _document(w: float, h: float, content: str) -> bytes:
    """Return a PDF of one page."""
    stream = content.encode("ascii")
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        (
            f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {w:.3f} {h:.3f}] /Contents 4 0 R "
            "/Resources << /Font << /F1 5 0 R >> >> >>"
        ).encode(),
        b"<< /Length %d >>\nstream\n%s\nendstream" % (len(stream), stream),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
    ]
    out = io.BytesIO()
    out.write(b"%PDF-1.4\n")
    places = []
    for number, each in enumerate(objects, 1):
        places.append(out.tell())
        out.write(b"%d 0 obj\n%s\nendobj\n" % (number, each))
    start = out.tell()
    out.write(b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1))
    out.writelines(b"%010d 00000 n \n" % place for place in places)
    out.write(b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, start))
    return out.getvalue()
