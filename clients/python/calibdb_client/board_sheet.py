"""A board on paper (PDF, in true size) or as a picture (PNG)."""

import io
import math
from collections.abc import Iterator
from itertools import groupby
from typing import Any

import numpy as np

from calibsolver.board import CIRCLES

from .board import Board, opencv
from .errors import UsageError

PAPERS_MM = {"a4": (297.0, 210.0), "a3": (420.0, 297.0), "letter": (279.4, 215.9)}
"""Width and height of the sheets, lying, mm."""
MARGIN_MM = 10.0
MAX_PNG_PX = 8192
DISK_ROWS = 96
_POINTS_PER_MM = 72 / 25.4
_TAG_BORDER = 2  # cells of black frame, as Kalibr prints AprilGrids; of other markers it is one
Rectangle = tuple[float, float, float, float]


def largest_square_mm(board: Board, paper: str) -> float:
    """Return the side of the largest square, in whole half millimetres, with which the board fits a sheet."""
    (w, h), (columns, rows) = _sheet(board, paper), board.size
    quiet = 2 * _quiet(board)
    side = min((w - 2 * MARGIN_MM) / (columns + quiet), (h - 3 * MARGIN_MM) / (rows + quiet))
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
    (columns, rows), quiet = board.size, _quiet(board)
    left, top = (w - side * columns) / 2, (h - MARGIN_MM - side * rows) / 2
    sheet = "0 g"
    if board.inverted:
        grown = (columns + 2 * quiet) * side, (rows + 2 * quiet) * side
        sheet = f"0 g {_rectangle(left - quiet * side, top - quiet * side, *grown, h)} f 1 g"
    drawn = "\n".join(
        _rectangle(left + side * x, top + side * y, side * a, side * b, h) for x, y, a, b in black(board)
    )
    said = f"calibDB board: {_details(board, side)}. Print at 100 %, and glue it to something flat."
    text = f"BT /F1 8 Tf {_pt(MARGIN_MM):.2f} {_pt(MARGIN_MM / 2):.2f} Td ({said}) Tj ET"
    return _document(_pt(w), _pt(h), f"{sheet}\n{drawn}\nf\n0 g\n{text}\n")


def png(board: Board, square_px: int = 120) -> bytes:
    """Return a picture of the board with a margin of half a square. Raises UsageError for a wrong size."""
    cv2 = opencv()
    w, h = (round(square_px * (n + 1)) for n in board.size)
    if not square_px >= 16 or max(w, h) > MAX_PNG_PX:
        raise UsageError(f"squares have 16 px or more, the picture at most {MAX_PNG_PX} px, not {w} x {h}")
    picture = np.full((h, w), 255, dtype=np.uint8)
    margin = square_px // 2
    for x, y, a, b in black(board):
        left, top, right, bottom = (round(margin + square_px * each) for each in (x, y, x + a, y + b))
        picture[top:bottom, left:right] = 0
    _, encoded = cv2.imencode(".png", 255 - picture if board.inverted else picture)
    return bytes(encoded)


def black(board: Board) -> Iterator[Rectangle]:
    """Yield the printed cells: left, top, width, height, board units from the top left, y down.

    Those of an inverted board are white, on black.
    """
    columns, rows = board.squares
    if board.kind == "aprilgrid":
        yield from _tags(board)
        return
    if board.kind in CIRCLES:
        yield from _disks(board)
        return
    places: list[Any] = []
    if board.kind == "charuco":
        drawn: Any = board.opencv()
        places = [np.asarray(corners)[:, :2] for corners in drawn.getObjPoints()]
    with_marker = {tuple(np.floor(place.mean(axis=0)).astype(int).tolist()) for place in places}
    for y in range(rows):
        for x in range(columns):
            if (x, y) not in with_marker and (places or (x + y) % 2 == 0):
                yield x, y, 1.0, 1.0
    for identifier, place in enumerate(places):
        left, top = place.min(axis=0).tolist()
        yield from _marker(board, identifier, left, top, board.marker_ratio)


def _disks(board: Board) -> Iterator[Rectangle]:
    """Yield circles as runs of thin rows, each as wide as the circle in its middle."""
    radius = board.marker_ratio / 2
    height = 2 * radius / DISK_ROWS
    for x, y in board.places.tolist():
        for row in range(DISK_ROWS):
            off = -radius + (row + 0.5) * height
            half = math.sqrt(radius**2 - off**2)
            yield x - half, y + off - height / 2, 2 * half, height


def _tags(board: Board) -> Iterator[Rectangle]:
    """Yield the cells of an AprilGrid, and a square in every gap where four tags meet."""
    (columns, rows), pitch, gap = board.squares, 1 + board.tag_spacing, board.tag_spacing
    for y in range(rows):
        for x in range(columns):
            yield from _marker(board, (rows - 1 - y) * columns + x, x * pitch, y * pitch, 1.0)
            if y + 1 < rows and x + 1 < columns:
                yield x * pitch + 1, y * pitch + 1, gap, gap


def _marker(board: Board, identifier: int, left: float, top: float, side: float) -> Iterator[Rectangle]:
    dictionary = board.markers()
    border = _TAG_BORDER if board.kind == "aprilgrid" else 1
    cells = dictionary.markerSize + 2 * border
    picture = opencv().aruco.generateImageMarker(dictionary, identifier, cells, borderBits=border)
    cell = side / cells
    for row, line in enumerate(picture < 128):
        yield from _runs(line.tolist(), left, top + row * cell, cell)


def _runs(line: list[bool], left: float, top: float, cell: float) -> Iterator[Rectangle]:
    """Yield the runs of black cells in one row of a marker: in one piece, without hairlines."""
    column = 0
    for is_black, run in groupby(line):
        count = len(list(run))
        if is_black:
            yield left + column * cell, top, count * cell, cell
        column += count


def _details(board: Board, side: float) -> str:
    if board.kind in CIRCLES:
        return f"{board}, {side:g} mm from row to row"
    unit = "tags" if board.kind == "aprilgrid" else "squares"
    return str(board).replace(unit, f"{unit} of {side:g} mm", 1)


def _quiet(board: Board) -> float:
    """Black about an inverted board, board units: its outermost cells need an edge."""
    return 0.25 if board.inverted else 0.0


def _rectangle(left: float, top: float, width: float, height: float, page: float) -> str:
    """Return a rectangle in millimetres, y down, as PDF has it: points, y up."""
    return f"{_pt(left):.4f} {_pt(page - top - height):.4f} {_pt(width):.4f} {_pt(height):.4f} re"


def _sheet(board: Board, paper: str) -> tuple[float, float]:
    if paper not in PAPERS_MM:
        raise UsageError(f"a sheet is one of {', '.join(PAPERS_MM)}, not {paper!r}")
    w, h = PAPERS_MM[paper]
    return (w, h) if board.size[0] >= board.size[1] else (h, w)


def _pt(millimetres: float) -> float:
    return millimetres * _POINTS_PER_MM


def _document(w: float, h: float, content: str) -> bytes:
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
