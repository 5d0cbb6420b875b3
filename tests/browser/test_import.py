"""Calibration files of other programs."""

import functools
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from calibsolver import Board, View, fit
from calibsolver.formats import ExportSource, write
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.waiting import shown_calibration, uncaught
from tests.helpers.data import corner_views
from tests.helpers.solver.export_sources import subject

BOARD = Board((10, 7))
NAME = "LifeCam HD-3000 (045e:0779)"
SENT = {
    "camera", "platform", "img_size", "zoom", "distortion_model", "board", "capture",
    "index", "views",
}  # fmt: skip


@functools.cache
def captured() -> tuple[ExportSource, tuple[int, int]]:
    views, size = corner_views("opencv_right")
    fitted = fit(views, size)
    source = ExportSource(
        fitted.camera, numbered("opencv_right"), BOARD, NAME, rms=fitted.avg_reprojection_error
    )
    return source, size


def numbered(name: str) -> tuple[View, ...]:
    return tuple(BOARD.view(np.arange(len(view)), view.image_points) for view in corner_views(name)[0])


def telling(sent: list[Request]) -> list[str]:
    """Requests that could carry anything: all but those for the page's own files."""
    return [
        request.url
        for request in sent
        if request.method != "GET" or "?" in request.url or "/v1/" in request.url or request.post_data
    ]


def give(page: Page, tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    page.locator("#file").set_input_files(path)


def test_keypoints_become_a_calibration(page: Page, tmp_path: Path) -> None:
    kept, size = captured()
    sent: list[Request] = []
    page.goto("/import/")
    page.on("request", lambda request: sent.append(request))
    content = write(kept, "corners-vnl")
    give(page, tmp_path, content.filename, content.content)
    page.locator("#status", has_text="squares of the board").wait_for()
    assert [page.locator(f"#{side}").input_value() for side in ("columns", "rows")] == ["10", "7"]
    page.locator("#width").fill(str(size[0]))
    page.locator("#height").fill(str(size[1]))
    picture(page, "import-table", ["hand"], full=True)
    page.locator("#table button").click()
    page.locator("#status", has_text="13 views of a board of 10 × 7 squares, 640 × 480 px").wait_for()
    expect(page.locator("#views li")).to_have_count(13)
    assert telling(sent) == [], "nothing is sent before one asks for it"
    picture(page, "import-corners", ["hand"], full=True)
    expect(page.locator("#kind")).to_have_value("photographs")
    expect(page.locator("#camera")).to_have_value("lifecam hd 3000 045e 0779")
    page.locator("#camera").fill(f"{NAME}, corners-vnl")
    page.locator("#start").click()
    page.locator("#verdict").wait_for()
    calibration = shown_calibration(page)
    ours, theirs = calibration["camera_matrix"][0][0], float(kept.camera.matrix[0, 0])
    assert abs(ours / theirs - 1) < 0.003, "every view counts; the shape of the board moves it by some"
    assert calibration["platform"] == "photographs"
    assert "/result/?id=" in page.url
    page.go_back()
    expect(page.locator("#views .taken").first).to_be_visible()
    page.go_forward()
    expect(page.locator("#verdict")).to_be_visible()
    for request in sent:
        if request.post_data is not None:
            assert set(json.loads(request.post_data)) <= SENT


def test_too_few_views_are_not_stored_and_a_poor_result_has_its_verdict(page: Page, tmp_path: Path) -> None:
    page.goto("/import/")
    calibrate_views(page, tmp_path, 3)
    page.locator("#status", has_text="A calibration needs four views that agree").wait_for()
    expect(page.locator("#status")).to_contain_text("Nothing was stored")
    expect(page.locator("#verdict")).to_have_count(0)
    assert page.locator("#views .taken").count() == 3
    calibrate_views(page, tmp_path, 4)
    page.locator("#verdict", has_text="Poor").wait_for()
    expect(page.locator(".errors")).to_contain_text("Where the board was")
    expect(page.locator(".meaning")).to_contain_text("At a distance of")
    expect(page.locator(".reasons li").first).not_to_be_empty()
    expect(page.locator("#json")).not_to_be_empty()


def calibrate_views(page: Page, folder: Path, count: int) -> None:
    content = write(replace(captured()[0], views=numbered("opencv_left")[:count]), "photonvision")
    give(page, folder, content.filename, content.content)
    page.locator("#kind").select_option("photographs")
    page.locator("#camera").fill(f"{NAME}, opencv_left")
    page.locator("#start").click()


def test_a_file_without_keypoints_is_converted_and_compared(context: BrowserContext, tmp_path: Path) -> None:
    page = context.new_page()
    errors = uncaught(page)
    held = subject("rectilinear")
    sent: list[Request] = []
    page.goto("/import/")
    page.on("request", lambda request: sent.append(request))
    for form, shown in (("mrcal", False), ("ros", True)):
        file = write(held, form)
        give(page, tmp_path, file.filename, file.content)
        page.locator("#guess h2", has_text="packed" if form == "mrcal" else "no measurements").wait_for()
        assert page.locator("#matrix").count() == int(shown), form
        expect(page.locator("#form")).to_be_hidden()
        if shown:
            fx = float(page.locator("#matrix td").first.text_content() or "")
            assert fx == pytest.approx(held.camera.matrix[0, 0], abs=1e-3)
    assert telling(sent) == []

    page.locator("#open-file").click()
    expect(page.locator("#converted-values")).to_contain_text(f"{held.camera.matrix[0, 0]:.2f}")
    page.locator(".converted .compare canvas").nth(1).wait_for()
    page.locator("#convert-format").select_option("gltf")
    with page.expect_download() as downloaded:
        page.locator("#convert").click()
    assert downloaded.value.suggested_filename.endswith(".gltf")
    expect(page.locator("#convert-done")).to_contain_text("This format cannot hold the lens exactly")
    page.locator("#compare-query").fill("nothing like it")
    page.locator("#compare-search").click()
    expect(page.locator("#compare-result")).to_contain_text("No camera of this name")
    # Of a text that is not loaded, a page shows the name: "result.before".
    assert re.findall(r"\b(?:result|formats|import)\.[a-z_]+", page.locator("main").inner_text()) == []
    picture(page, "import-converted", full=True, check=False)
    bodies = [json.loads(request.post_data) for request in sent if request.post_data]
    assert all(set(body) <= {"file", "encoding", "format", "camera", "img_size"} for body in bodies)

    give(page, tmp_path, "k.yaml", b"K: [900, 0, 640, 0, 900, 360, 0, 0, 1]\nD: [0.1, 0, 0, 0, 0]\n")
    page.locator("#open-file").click()
    expect(page.locator("#convert-status")).to_contain_text("Enter their size")
    page.locator("#convert-width").fill("1280")
    page.locator("#convert-height").fill("720")
    page.locator("#open-file").click()
    expect(page.locator("#converted-values")).to_contain_text("900.00")

    # Every exported format that holds corners comes back: the service unpacks mrcal's.
    packed = write(captured()[0], "mrcal")
    give(page, tmp_path, packed.filename, packed.content)
    page.locator("#unpack").click()
    page.locator("#status", has_text="13 views of a board of 10 × 7 squares, 640 × 480 px").wait_for()
    expect(page.locator("#guess")).to_be_hidden()
    expect(page.locator("#form")).to_be_visible()
    assert errors == []


def test_what_is_malformed_is_said_and_not_sent(page: Page, tmp_path: Path) -> None:
    sent: list[Request] = []
    page.goto("/import/")
    page.on("request", lambda request: sent.append(request))
    whole = write(captured()[0], "photonvision").content
    for name, content, said in (
        ("cut.json", whole[:2000], "damaged"),
        ("picture.jpg", b"\xff\xd8\xff\xe0" + bytes(range(256)) * 20, "as a calibration file"),
    ):
        give(page, tmp_path, name, content)
        page.locator("#problem", has_text=said).wait_for()
        expect(page.locator("#form")).to_be_hidden()
        expect(page.locator("#views li")).to_have_count(0)
    large = tmp_path / "large.json"
    with large.open("wb") as file:
        file.truncate(64_000_001)
    page.locator("#file").set_input_files(large)
    page.locator("#problem", has_text="larger than 64 MB").wait_for()
    picture(page, "import-large", ["hand"], full=True)
    page.locator("#language").select_option("uk")
    page.locator("#problem", has_text="більший за 64 МБ").wait_for()
    assert telling(sent) == []
