"""Calibration of several cameras, with outages."""

import json
import subprocess
from pathlib import Path
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Route, expect

from tests.helpers.browser.firefox import executable
from tests.helpers.browser.interruptions import HIDE
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.specimens import answer, rig
from tests.helpers.browser.waiting import until

from ..conftest import THOROUGH

RIG = "/rig/?virtual=1&rate=5&img_size=320x240&error=0.5"
TRUE_POSE = "async (position) => (await import('/rig/scene.js')).cameraPose(position)"
MAX_SIGMAS = 5.0
MAX_SHIFT = 0.02


def rig_id(page: Page) -> str:
    found: str = page.evaluate("new URLSearchParams(location.search).get('id')")
    return found


def moments(page: Page) -> int:
    return page.locator("#moment-list li").count()


def expect_true_pose(page: Page, result: dict[str, Any]) -> None:
    true = page.evaluate(TRUE_POSE, 1)
    found = result["extrinsics"][1]
    error = np.abs(np.subtract(found["rvec"] + found["tvec"], true["rvec"] + true["tvec"]))
    assert (error < MAX_SIGMAS * np.array(found["std"])).all(), (error / found["std"]).round(1)
    assert np.linalg.norm(np.subtract(found["tvec"], true["tvec"])) < MAX_SHIFT * np.linalg.norm(true["tvec"])


def saved(page: Page, name: str) -> str:
    with page.expect_download() as download:
        page.locator(f"#file-{name}").click()
    return Path(download.value.path()).read_text()


def test_stereo_camera_in_one_stream_is_calibrated(page: Page, api: httpx.Client, tmp_path: Path) -> None:
    page.goto(f"{RIG}&layout=side_by_side")
    page.locator("#moment-list li").first.wait_for()
    aspects = "all => all.map((one) => one.clientWidth / one.clientHeight)"
    shapes = page.locator(".picture .stage").evaluate_all(aspects)
    assert np.allclose(shapes, 320 / 240, atol=0.02)
    page.evaluate(HIDE, True)  # so that it is not over before it is looked at
    picture(page, "rig-during", ["desk"])
    if THOROUGH:
        before = moments(page)
        page.locator("#moment-list button").last.click()
        expect(page.locator("#moment-list li")).to_have_count(before - 1)
    page.evaluate(HIDE, False)
    page.locator("#done:not([hidden])").wait_for()
    assert page.evaluate("document.activeElement.id") == "result-title"
    picture(page, "rig-result", ["hand"], full=True, check=False)  # held to the rules with all pages

    result = json.loads(saved(page, "json"))
    expect_true_pose(page, result)
    path = tmp_path / "stereo.yml"
    path.write_text(saved(page, "opencv_stereo"))
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    np.testing.assert_allclose(file.getNode("T").mat().ravel(), result["extrinsics"][1]["tvec"], atol=1e-6)
    assert json.loads(saved(page, "gltf"))["cameras"]
    labels = [api.get(f"/calibrations/{each}").json()["camera"] for each in result["cameras"]]
    assert [label.rsplit(" ", 1)[1] for label in labels] == ["left", "right"]
    expect(page.locator(".epipolar canvas")).to_have_count(2)
    state = api.get(f"/rigs/{rig_id(page)}").raise_for_status().json()
    assert state["result"]["extrinsics"] == result["extrinsics"]


def test_page_of_a_finished_rig_draws_it_and_the_boards_shape(page: Page) -> None:
    answer(page, "**/v1/rigs/*", rig)
    page.goto(f"/rig/?id={rig()['rig_id']}")
    expect(page.locator("#done header")).to_contain_text(
        "Your board is bent by 0.90\u00a0mm. That was taken into account."
    )
    expect(page.locator("#done .scene .camera")).to_have_count(2)
    assert page.locator("#done .scene .board").count() >= 4
    page.set_viewport_size(SIZES["desk"])
    right = page.locator("#verdict").bounding_box() or {}
    scene = page.locator("#done .scene").bounding_box() or {}
    assert scene["x"] > right["x"] + 400
    assert scene["y"] + scene["height"] < 900


@pytest.mark.thorough
def test_firefox_leads_and_is_killed_chromium_loses_its_network(
    stack: str, context: BrowserContext, api: httpx.Client, tmp_path: Path
) -> None:
    script = Path(__file__).parents[1] / "helpers" / "browser" / "firefox_rig.mjs"
    leader = subprocess.Popen(
        ["node", str(script), executable("firefox-esr"), f"{stack}{RIG}&others=1", str(tmp_path / "profile")],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert leader.stdout
        code = json.loads(leader.stdout.readline())["code"]
        follower = context.new_page()
        follower.goto(f"{RIG}&position=1&code={code.lower()}")
        follower.locator("#moment-list li", has_text="cameras 1 and 2").first.wait_for()

        lost: list[Any] = []

        def lose(route: Route) -> None:
            if route.request.method == "POST" and route.request.url.endswith("/session/views"):
                lost.append(route.request.post_data_json)
            if lost:
                route.abort()
            else:
                route.continue_()

        follower.route("**/v1/**", lose)
        expect(follower.locator("#detail")).to_contain_text("1 view is kept on this device")
        follower.unroute("**/v1/**")
        follower.locator("#done:not([hidden])").wait_for()
        ended = json.loads(leader.stdout.readline())
    finally:
        leader.kill()
        leader.communicate()
    assert ended["complaints"] == []
    assert ended["kept"] >= ended["before"], "a killed browser loses no moment"
    state = api.get(f"/rigs/{ended['id']}").raise_for_status().json()
    late = next(moment for moment in state["moments"] if moment["id"] == lost[0]["moment"])
    assert late["positions"] == [0, 1]
    assert all(moment["positions"] for moment in state["moments"])
    expect_true_pose(follower, state["result"])


@pytest.mark.thorough
def test_page_killed_offline_delivers_its_views(context: BrowserContext, api: httpx.Client) -> None:
    sent: list[Any] = []

    def lose(route: Route) -> None:
        if route.request.url.endswith("/session/views"):
            sent.append(route.request.post_data_json)
        route.abort()

    page = context.new_page()
    page.goto(RIG)
    page.locator("#moment-list li").first.wait_for()
    # The network fails when a view is sent: without it no further moment is opened.
    context.route("**/v1/session/views", lose)
    until(page, lambda: sent)
    for address in ("**/v1/**", "**/config.json"):
        context.route(address, lose)
    expect(page.locator("#detail")).to_contain_text("kept on this device")
    page.close()
    page = context.new_page()
    page.goto("/rig/")
    page.locator("#go-on").click()
    expect(page.locator("#detail")).to_contain_text("kept on this device")
    context.unroute_all(behavior="wait")
    page.locator("#done:not([hidden])").wait_for()
    known = api.get(f"/rigs/{rig_id(page)}").raise_for_status().json()["moments"]
    assert next(each for each in known if each["id"] == sent[0]["moment"])["positions"] == [0, 1]
