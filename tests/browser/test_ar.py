"""What is drawn lies where it should, measured in the pictures that the page shows."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from playwright.sync_api import Page

from .firefox import in_firefox

Array = npt.NDArray[np.float64]

ADDRESS = "/ar/?virtual=1&k1=-0.3&error=0"
READ = Path(__file__).with_name("ar.js").read_text()
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
PARAMETERS = cv2.aruco.CharucoParameters()
PARAMETERS.minMarkers = 1  # at the picture's corner there is no second one
DETECTOR = cv2.aruco.CharucoDetector(cv2.aruco.CharucoBoard((9, 6), 1.0, 0.65, DICTIONARY), PARAMETERS)
CORNERS = (0, 7, 32, 39)  # the outermost, which have marks
COLUMNS = 8
OUTER = {0, 1, 6, 7}  # columns where no house stands
AT_THE_CORNER = 0.14 * np.hypot(1280, 720)  # px; nearer there is no whole marker to tell the corner by
WINDOW = 8  # px; half that of a corner's surroundings
ARM = 14  # px; of a crossing's: lines are up to 9 px wide


def decoded(layer: dict[str, Any]) -> npt.NDArray[np.uint8]:
    data = np.frombuffer(base64.b64decode(layer["png"].split(",")[1]), np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def seen(picture: npt.NDArray[np.uint8]) -> dict[int, Array]:
    """Find the board's corners: id → px."""
    grey = cv2.cvtColor(picture[..., :3], cv2.COLOR_BGR2GRAY)
    points, ids, _, _ = DETECTOR.detectBoard(grey)
    return dict(zip(ids.ravel().tolist(), refined(grey, points.reshape(-1, 2), WINDOW), strict=True))


def refined(grey: npt.NDArray[np.uint8], points: Array, half: int) -> Array:
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
    start = points.astype(np.float32).reshape(-1, 1, 2)
    return np.asarray(cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria)).reshape(-1, 2)


def crossings(colour: npt.NDArray[np.uint8], near: Array) -> Array:
    """Find where lines cross: on a softer picture, since a wide line's edges are not its middle."""
    return refined(cv2.GaussianBlur(colour, (0, 0), 1.5), near, ARM)


def marks(overlay: npt.NDArray[np.uint8]) -> Array:
    """Find the blue crosses, which are bluer than the house: their middles, px."""
    blue, _, red, alpha = (overlay[..., channel].astype(float) for channel in range(4))
    blueness = np.round(np.clip(blue - red, 0, None) * alpha / 255).astype(np.uint8)
    count, _, boxes, middles = cv2.connectedComponentsWithStats((blueness > 200).astype(np.uint8))
    whole = [n for n in range(1, count) if boxes[n][cv2.CC_STAT_AREA] > 100]
    return crossings(blueness, middles[whole])


def at_the_corner(look: dict[str, Any]) -> tuple[float, float]:
    """Give the misalignment of the mark nearest to the picture's corner, and how far it is from that, px."""
    picture, overlay = decoded(look["picture"]), decoded(look["overlay"])
    h, w = picture.shape[:2]
    assert overlay.shape[:2] == (h, w)
    assert look["picture"]["place"] == look["overlay"]["place"], "one lies over the other"
    corners, drawn = seen(picture), marks(overlay)
    assert 1 <= len(drawn) <= 4
    away = {
        index: float(np.hypot(min(u, w - 1 - u), min(v, h - 1 - v)))
        for index, (u, v) in corners.items()
        if index in CORNERS
    }
    nearest = min(away, key=lambda index: away[index])
    return float(np.linalg.norm(drawn - corners[nearest], axis=1).min()), away[nearest]


def over_the_grid(look: dict[str, Any]) -> Array:
    """Give the misalignment of the drawn grid's crossings beside the house, px."""
    corners = seen(decoded(look["picture"]))
    places = np.array(
        [place for index, place in corners.items() if index % COLUMNS in OUTER and index not in CORNERS]
    )
    overlay = decoded(look["overlay"]).astype(float)
    red = np.round(overlay[..., 2] * overlay[..., 3] / 255).astype(np.uint8)
    return np.linalg.norm(crossings(red, places) - places, axis=1)


def check(looks: dict[str, Any]) -> None:
    off = {name: at_the_corner(look) for name, look in looks.items()}
    grid = {name: over_the_grid(look) for name, look in looks.items() if name != "matrix"}
    for name, (distance, away) in off.items():
        print(f"{name}: {distance:.3f} px off, {away:.0f} px from the corner; {looks[name]['said']}")
    for name, errors in grid.items():
        rms = np.sqrt((errors**2).mean())
        print(f"{name}: {len(errors)} crossings, {rms:.3f} px rms, {errors.max():.3f} at most")
    assert all(away < AT_THE_CORNER for _, away in off.values())
    assert off["matrix"][0] > 8
    for name in ("rectified", "whole", "distorted"):
        assert off[name][0] < 0.5, name
        assert len(grid[name]) >= 8
        assert grid[name].max() < 0.5, name


def test_overlays_fit_once_the_lens_is_known(page: Page) -> None:
    page.goto(ADDRESS)
    page.locator("#rms:not(:empty)").wait_for()
    check(page.evaluate(READ))


def test_overlays_fit_in_firefox(stack: str) -> None:
    check(in_firefox(f"{stack}{ADDRESS}", READ))
