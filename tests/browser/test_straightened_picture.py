"""A picture of the result page's visitor, straightened on their device."""

import base64
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.photographs import textured_board
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.specimens import answer, camera, result_of_camera
from tests.helpers.data import data_dir, external_data

RECTIFIED = """async ([calibration, file, balance]) => {
  const { Rectifier } = await import("/sdk/rectifier.js");
  const picture = await createImageBitmap(await (await fetch(file)).blob());
  const rectifier = new Rectifier(calibration, { balance });
  rectifier.draw(picture);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = calibration.img_size;
  const context = canvas.getContext("2d");
  context.drawImage(rectifier.canvas, 0, 0);
  const matrix = rectifier.camera_matrix;
  rectifier.dispose();
  return { matrix, png: canvas.toDataURL("image/png") };
}"""


@pytest.fixture(params=["drawn", pytest.param("real", marks=external_data)])
def photograph(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A photograph of 1280 x 720 px: drawn, or that of a real camera."""
    if request.param == "real":
        return sorted((data_dir() / "photos" / "charuco_1280x720").glob("*.jpg"))[0]
    path = tmp_path / "photograph.jpg"
    cv2.imwrite(str(path), cv2.GaussianBlur(textured_board((1280, 720)), (0, 0), 1.0))
    return path


def test_a_picture_is_straightened_on_this_device(page: Page, photograph: Path) -> None:
    answer(page, "**/v1/calibrations/*", result_of_camera)
    answer(page, "**/v1/cameras/*", camera)
    page.goto("/result/?id=x")
    page.locator("#trial-picture").wait_for(state="attached")
    page.locator("#agreement", has_text="agree").wait_for()
    sent: list[str] = []
    page.on("request", lambda request: sent.append(request.url))
    page.locator("#trial-picture").set_input_files(photograph)
    page.get_by_text("A square grid as your lens").wait_for(state="detached")
    page.locator(".compare canvas").nth(1).wait_for()
    page.locator(".compare input").fill("20")
    assert page.locator(".compare").evaluate("stage => stage.style.getPropertyValue('--cut')") == "0.2"
    assert [url for url in sent if not url.startswith("blob:")] == []
    picture(page, "result-straightened", ["hand"], full=True)


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_the_gpu_straightens_as_opencv_does(page: Page, photograph: Path, model: str) -> None:
    matrix = [[980.0, 0, 650], [0, 985, 352], [0, 0, 1]]
    coefficients = (
        [-0.28, 0.09, 0.001, -0.0005, -0.01] if model == "rectilinear" else [-0.03, 0.01, -0.004, 0.001]
    )
    calibration: dict[str, Any] = {
        "img_size": [1280, 720],
        "camera_matrix": matrix,
        "distortion_coefficients": coefficients,
        "distortion_model": model,
    }
    page.route("**/photograph", lambda route: route.fulfill(path=photograph))
    page.goto("/board/")
    made = page.evaluate(RECTIFIED, [calibration, "/photograph", 0.3])
    ours = cv2.imdecode(
        np.frombuffer(base64.b64decode(made["png"].split(",")[1]), np.uint8), cv2.IMREAD_GRAYSCALE
    )
    init = cv2.initUndistortRectifyMap if model == "rectilinear" else cv2.fisheye.initUndistortRectifyMap
    maps = init(
        np.array(matrix),
        np.array(coefficients),
        np.eye(3),
        np.array(made["matrix"]),
        (1280, 720),
        cv2.CV_32FC1,
    )
    grey = cv2.imread(str(photograph), cv2.IMREAD_GRAYSCALE)
    assert ours is not None
    assert grey is not None
    theirs = cv2.remap(grey, *maps, cv2.INTER_LINEAR)
    inside = (maps[0] > 1) & (maps[1] > 1) & (maps[0] < 1278) & (maps[1] < 718)
    difference = np.abs(ours.astype(int) - theirs.astype(int))[inside]
    print(f"{model}: mean {difference.mean():.3f}, 99.9 %: {np.quantile(difference, 0.999):.0f} grey levels")
    assert inside.mean() > 0.8
    assert theirs.std() > 20, "a picture with something in it"
    assert difference.mean() < 0.6
    assert np.quantile(difference, 0.999) <= 2
