"""Real data of the tests: corner sets in `tests/data/corners`, and data under other licences.

The environment variable CALIBDB_DATA names the folder of the latter.
"""

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibsolver import Board, View
from calibsolver.formats.grid import grid

ROOT = Path(__file__).resolve().parents[2]
COMMITTED = ROOT / "tests" / "data" / "corners"
EXTERNAL = Path(os.environ["CALIBDB_DATA"]) if os.environ.get("CALIBDB_DATA") else None

#: mark of a test that reads `data_dir()`: collected only where CALIBDB_DATA is set
external_data = pytest.mark.external_data


def data_dir() -> Path:
    """Folder of CALIBDB_DATA. Raises FileNotFoundError if it is unset or does not exist."""
    if EXTERNAL is None or not EXTERNAL.is_dir():
        raise FileNotFoundError(f"no data at {EXTERNAL}: set CALIBDB_DATA")
    return EXTERNAL


def is_committed(name: str) -> bool:
    return (COMMITTED / f"{name}.json").exists()


def available(names: Iterable[str]) -> list[str]:
    return [name for name in names if EXTERNAL is not None or is_committed(name)]


def corner_set(name: str) -> dict[str, Any]:
    """Corner set `{name, image_size [w, h], views [{file, obj [[X, Y, Z]], img [[x, y]], ids?, split?}]}`.

    `obj` in units of the board's own file, `img` in px, the centre of the first pixel at (0, 0).
    """
    path = COMMITTED / f"{name}.json"
    if not path.exists():
        external: dict[str, Any] = json.loads((data_dir() / "corners" / path.name).read_text())
        return external
    loaded: dict[str, Any] = json.loads(path.read_text())
    board = [[x, y, 0] for x, y in loaded.pop("board")]
    for view in loaded["views"]:
        view["obj"] = [board[corner] for corner in view.pop("corners", range(len(board)))]
    return loaded


def corner_views(name: str) -> tuple[list[View], tuple[int, int]]:
    """Views of a corner set, and the size (w, h) of its images."""
    data = corner_set(name)
    w, h = data["image_size"]
    return [View(v["obj"], v["img"]) for v in data["views"]], (w, h)


def on_board(views: Sequence[View]) -> tuple[Board, tuple[tuple[int, ...], ...], tuple[View, ...]]:
    """Board that views of a set show, and for each view the ids of its corners and the view on that board."""
    numbered = grid(views)
    board = Board(numbered.squares, dictionary="DICT_4X4_1000")
    pairs = zip(numbered.ids, views, strict=True)
    return board, numbered.ids, tuple(board.view(ids, view.image_points) for ids, view in pairs)


def float32(views: Sequence[View]) -> tuple[list[Any], list[Any]]:
    return (
        [view.object_points.astype(np.float32) for view in views],
        [view.image_points.astype(np.float32) for view in views],
    )
