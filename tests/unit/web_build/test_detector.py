"""The pages' detector: the committed files are those of its build, and find what the Python package finds."""

import dataclasses
import hashlib
import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from calibsolver import Board
from tests.helpers.browser import photographs
from tests.helpers.data import data_dir, external_data
from tests.helpers.marks import thorough
from tests.helpers.node import run_module

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "infra/web_build/detector"
MADE = json.loads((FOLDER / "opencv.json").read_text())
MAX_BYTES = 1_000_000  # on the wire, with the fast Brotli of an edge
BOARD = {
    "squares": [photographs.SQUARES, photographs.SQUARES],
    "marker_ratio": photographs.MARKER_RATIO,
    "dictionary": photographs.DICTIONARY,
}
#: px; the package rounds sums of floats in another order
MAX_CORNER_DIFFERENCE = 2e-4
#: px, of nine markers in ten: refining a small one may end at another edge
MAX_MARKER_DIFFERENCE = 1e-3


def test_committed_files_are_those_of_the_build() -> None:
    for name, digest in MADE["sha256"].items():
        assert hashlib.sha256((FOLDER / name).read_bytes()).hexdigest() == digest, name
    script = (FOLDER / "build.sh").read_text()
    for value in (MADE["version"], MADE["source"]["package"], MADE["source"]["sha256"]):
        assert value in script
    assert MADE["bytes"] == (FOLDER / "opencv.wasm").stat().st_size


def test_its_version_is_that_of_the_python_package() -> None:
    (locked,) = re.findall(
        r"^opencv-contrib-python-headless==(\S+)", (ROOT / "requirements.lock").read_text(), re.M
    )
    assert MADE["version"] == locked


def test_no_function_is_made_from_a_string() -> None:
    assert not re.search(r"new Function|\beval\(", (FOLDER / "opencv.js").read_text())


def test_it_travels_in_a_megabyte() -> None:
    compress = """import { readFileSync } from "node:fs";
    import { brotliCompressSync, constants } from "node:zlib";
    const params = { [constants.BROTLI_PARAM_QUALITY]: 5 };
    console.log(brotliCompressSync(readFileSync(process.argv[1]), { params }).length);"""
    sizes = [run_module(compress, str(FOLDER / name)) for name in ("opencv.js", "opencv.wasm")]
    assert sum(sizes) <= MAX_BYTES


@pytest.mark.parametrize("count", [1, *thorough(12)])
def test_corners_in_drawn_pictures_are_those_of_the_python_package(count: int, tmp_path: Path) -> None:
    drawn = photographs.draw(tmp_path, count)
    assert corners_agree(drawn, BOARD, tmp_path) > 33 * count


@external_data
@pytest.mark.parametrize(("size", "count"), thorough(("640x480", 17), ("1280x720", 16)))
def test_corners_in_photographs_are_those_of_the_python_package(
    size: str, count: int, tmp_path: Path
) -> None:
    pictures = sorted((data_dir() / "photos" / f"charuco_{size}").glob("*.jpg"))[:count]
    assert corners_agree(pictures, BOARD, tmp_path) > 23 * len(pictures) == 23 * count


@external_data
@pytest.mark.thorough
def test_no_trouble_is_suspected_where_a_real_board_is_well_detected(tmp_path: Path) -> None:
    """In at most 2 % of the frames of a hand-held glossy board whose corners fit a plane to 0.3 px."""
    from tests.helpers.browser import stop_and_go  # with Playwright, which no other test here needs

    frames = stop_and_go.frames_of(data_dir() / "videos" / "caliscope_opt1.mp4")
    greys = [cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) for frame in frames]
    board = Board((4, 5), 0.75, inverted=True)
    task = {"pictures": written(greys, tmp_path), "board": dataclasses.asdict(board)}
    suspected = []
    for answer in run_module('import "./tests/helpers/suspect.mjs";', sent=task):
        if len(answer["ids"]) < 8:
            continue
        view = board.view(answer["ids"], answer["points"])
        places = view.object_points[:, :2]
        homography, _ = cv2.findHomography(places, view.image_points)
        off = cv2.perspectiveTransform(places[None], homography)[0] - view.image_points
        if np.sqrt(np.mean(np.sum(off**2, axis=1))) <= 0.3:
            suspected.append(answer["suspected"])
    assert len(suspected) >= 40
    assert sum(trouble is not None for trouble in suspected) <= 0.02 * len(suspected)


def corners_agree(pictures: list[Path], board: dict[str, Any], folder: Path) -> int:
    """Compare both detectors in every picture; return the number of the board's corners."""
    greys = [np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)) for path in pictures]
    task = {"pictures": written(greys, folder), "board": board}
    answers = run_module('import "./tests/helpers/detect.mjs";', sent=task)
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board["dictionary"]))
    charuco = cv2.aruco.CharucoBoard(board["squares"], 1, board["marker_ratio"], dictionary)
    refinement = cv2.aruco.RefineParameters(10, 3, True)
    detector = cv2.aruco.CharucoDetector(
        charuco, cv2.aruco.CharucoParameters(), cv2.aruco.DetectorParameters(), refinement
    )
    tags = cv2.aruco.ArucoDetector(dictionary, cv2.aruco.DetectorParameters(), refinement)
    corner_differences: list[float] = []
    marker_differences: list[float] = []
    for grey, answer in zip(greys, answers, strict=True):
        points, ids, _, _ = detector.detectBoard(grey)
        assert answer["ids"] == ([] if ids is None else ids.ravel().tolist())
        if answer["ids"]:
            corner_differences += (
                np.abs(np.array(answer["points"]) - points.reshape(-1, 2)).max(axis=1).tolist()
            )
        corners, numbers, _ = tags.detectMarkers(grey)
        theirs = {} if numbers is None else dict(zip(numbers.ravel().tolist(), corners, strict=True))
        assert {marker["id"] for marker in answer["markers"]} == set(theirs)
        marker_differences += [
            float(np.abs(np.array(marker["corners"]) - theirs[marker["id"]].reshape(4, 2)).max())
            for marker in answer["markers"]
        ]
    assert max(corner_differences) <= MAX_CORNER_DIFFERENCE
    assert np.quantile(marker_differences, 0.9) <= MAX_MARKER_DIFFERENCE
    return len(corner_differences)


def written(greys: list[Any], folder: Path) -> list[dict[str, Any]]:
    """Write grey pictures into a folder; return them as the scripts take them."""
    request = []
    for number, grey in enumerate(greys):
        path = folder / f"{number}.grey"
        path.write_bytes(grey.tobytes())
        request.append({"path": str(path), "size": [grey.shape[1], grey.shape[0]]})
    return request
