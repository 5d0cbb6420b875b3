"""A picture of the result page's visitor, straightened on their device."""

from pathlib import Path

import cv2
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.photographs import textured_board
from tests.helpers.browser.specimens import answer, camera, result_of_camera
from tests.helpers.data import EXTERNAL, data_dir, external_data
from tests.helpers.marks import thorough

#: stands in for the real one
DRAWN = ["drawn"] if EXTERNAL is None else thorough("drawn")


@pytest.fixture(params=[*DRAWN, pytest.param("real", marks=external_data)])
def photograph(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
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
