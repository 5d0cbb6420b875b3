"""Boards of the Python client: equal to OpenCV's, in true size on paper, refused where they cannot exist."""

import argparse
import io
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibdb_client import Board, UsageError
from calibdb_client.board_sheet import largest_square_mm, pdf, png
from calibdb_client.cli.options import add_board, chosen_board
from tests.helpers.command import calibdb


def test_board_is_black_where_opencv_draws_it() -> None:
    cell = 120
    for board in (Board(), Board((8, 8), 0.75, "DICT_5X5_100"), Board((6, 8), 0.5, legacy=True)):
        drawn = cv2.imdecode(np.frombuffer(png(board, cell), dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
        w, h = (cell * n for n in board.squares)
        expected = board.opencv().generateImage((w, h), marginSize=0, borderBits=1)
        off = drawn[cell // 2 :, cell // 2 :][:h, :w].astype(int) - expected
        assert (np.abs(off) > 128).mean() < 0.01


def test_sheet_has_its_size_and_says_what_the_board_is() -> None:
    import pypdf  # which every worker would load, to collect the tests

    page = pypdf.PdfReader(io.BytesIO(pdf(Board(), "a4", 25))).pages[0]
    assert [round(float(each) / 72 * 25.4, 2) for each in page.mediabox[2:]] == [297.0, 210.0]
    assert "9 x 6 squares of 25 mm" in page.extract_text()
    widths = [
        float(line.split()[2])
        for line in page.get_contents().get_data().decode().splitlines()
        if line.endswith(" re")
    ]
    assert max(widths) == pytest.approx(25 / 25.4 * 72, abs=1e-3)
    assert (largest_square_mm(Board((9, 6)), "a4"), largest_square_mm(Board((6, 9)), "a4")) == (30, 29.5)
    with pytest.raises(UsageError, match="1 to"):
        pdf(Board(), "a4", 60)
    circles = Board((7, 5), kind="circles", marker_ratio=0.5)
    assert b"circles, 7 x 5, diameter 0.5, 20 mm from row to row" in pdf(circles, "a4", 20)


@pytest.mark.usefixtures("working")
def test_board_command_writes_both(capfd: pytest.CaptureFixture[str]) -> None:
    assert calibdb("board --pdf board.pdf --png board.png --squares 8x8") == 0
    assert all(Path(name).stat().st_size > 1000 for name in ("board.pdf", "board.png"))
    assert calibdb("board") == 2
    assert calibdb("board --pdf absent/board.pdf") == 2
    assert calibdb("board --png board.png --squares 20x20") == 2
    assert "larger dictionary" in capfd.readouterr().err


@pytest.mark.parametrize(
    "wrong",
    [{"squares": (2, 9)}, {"squares": (60, 9), "kind": "chessboard"}, {"marker_ratio": 0.2}],
)
def test_board_that_cannot_exist_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        Board(**wrong)


def test_board_on_a_screen_says_so() -> None:
    chosen = argparse.ArgumentParser()
    add_board(chosen)
    board = chosen_board(chosen.parse_args(["--on-screen", "--squares", "8x5"]))
    assert board == Board((8, 5), surface="screen")
    assert str(board).endswith("DICT_4X4_50, on a screen")
    assert board.record()["surface"] == "screen"
    assert "surface" not in Board().record(), "older services do not know it"
