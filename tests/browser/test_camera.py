"""A camera as the browser opens it: getUserMedia, a video file in place of the sensor."""

import json
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Playwright

from .conftest import CHROMIUM, executable

WIDTH, HEIGHT = 1280, 720
SQUARE = 80  # texture pixels


def board_seen() -> tuple[np.ndarray, np.ndarray]:
    """Grey picture of the default board as OpenCV draws it, tilted, and where its corners are, (40, 2)."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((9, 6), 1, 0.65, dictionary)
    texture = board.generateImage((11 * SQUARE, 8 * SQUARE), marginSize=SQUARE)
    matrix = np.array([[1000, 0, 640], [0, 1000, 360], [0, 0, 1.0]])
    rotation, translation = np.array([0.25, -0.45, 0.05]), np.array([-4.0, -2.8, 10.0])
    plane = matrix @ np.column_stack([cv2.Rodrigues(rotation)[0][:, :2], translation])
    # Texture pixel → board: the origin is the edge of the first square, half a pixel before its centre.
    to_board = np.array([[1 / SQUARE, 0, 0.5 / SQUARE - 1], [0, 1 / SQUARE, 0.5 / SQUARE - 1], [0, 0, 1]])
    size = (WIDTH, HEIGHT)
    picture = cv2.warpPerspective(
        texture,
        plane @ to_board,
        size,
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=120,
    )
    corners = np.array([(x, y, 0.0) for y in range(1, 6) for x in range(1, 9)])
    points = cv2.projectPoints(corners, rotation, translation, matrix, None)[0].reshape(-1, 2)
    return cv2.GaussianBlur(picture, (0, 0), 0.7), points


def video(path: Path, grey: np.ndarray) -> Path:
    """Write one picture as a YUV4MPEG2 file, which Chromium shows over and over."""
    luma = (16 + grey.astype(np.float64) * (219 / 255)).round().astype(np.uint8).tobytes()
    chroma = bytes([128]) * (WIDTH * HEIGHT // 2)
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{WIDTH} H{HEIGHT} F20:1 Ip A1:1 C420mpeg2\n".encode())
        for _ in range(4):
            file.write(b"FRAME\n" + luma + chroma)
    return path


def test_first_view_and_lookup_through_a_real_camera(
    playwright: Playwright, stack: str, tmp_path: Path
) -> None:
    grey, truth = board_seen()
    source = video(tmp_path / "board.y4m", grey)
    flags = [
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-video-capture={source}",
    ]
    browser = playwright.chromium.launch(executable_path=executable("chromium"), args=CHROMIUM + flags)
    page = browser.new_page(base_url=stack)
    page.goto("/calibrate/")
    page.locator("#camera option").nth(1).wait_for(state="attached")
    with page.expect_request("**/v1/session/views", timeout=30_000) as view:
        page.locator("#start").click()
    answer = view.value.response()
    assert answer is not None
    state = answer.json()
    sent = json.loads(view.value.post_data or "")
    mirrored = page.locator("#stage.mirrored").count()
    page.locator("#stop").click()
    if state["views"]:  # a stop that loses views is asked for twice
        page.locator("#stop").click()
    page.locator("#welcome:not([hidden])").wait_for()

    page.goto("/")
    page.locator("#look").click()
    page.locator("#outcome a").click()
    page.locator("#wanted").wait_for()
    wanted = page.locator("#wanted").text_content()
    browser.close()
    errors = np.linalg.norm(np.array(sent["points"]) - truth[sent["ids"]], axis=1)
    print(f"{len(errors)} corners, {np.sqrt((errors**2).mean()):.3f} px rms; camera {state['camera']!r}")
    assert len(errors) == 40
    assert np.sqrt((errors**2).mean()) < 0.1
    assert state["img_size"] == [WIDTH, HEIGHT]
    assert state["camera"]
    assert mirrored == 1
    assert state["camera"] in (wanted or "")
