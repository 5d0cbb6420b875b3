"""Examples of the documents on pages of other origins, search and trial calls."""

import json
import re
import subprocess
from collections.abc import Iterator
from contextlib import nullcontext
from functools import partial
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from playwright.sync_api import BrowserContext, Page, Route, expect

from infra.web_build.openapi import EXAMPLES_PATH
from tests.helpers.browser.captures import capture
from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.scenes import BLIND_DETECTOR, webcam
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.browser.truth import Truth
from tests.helpers.browser.waiting import address, uncaught, until
from tests.helpers.documents import SITE, blocks

from .conftest import ROOT, TOKEN

C920 = "HD Pro Webcam C920 (046d:082d)"
EXAMPLES = json.loads(EXAMPLES_PATH.read_text().replace(C920, "C 1"))
BUNDLE = {"format": "calibdb-bundle", "version": 1, "columns": [], "cameras": [], "labels": {}, "places": {}}
NO_ICON = '<link rel="icon" href="data:,">'
EXPORT = """async ([id, token, api]) => {
  const headers = { authorization: `Bearer ${token}` };
  const response = await fetch(`${api}/calibrations/${id}?format=ros`, { headers });
  return [response.status, response.headers.get("x-conversion-error"), await response.text()];
}"""
WORKER = """import { lookup } from "/sdk/calibdb.js";
onmessage = async ({ data }) => postMessage((await lookup(data, { token: "cdb_dev_local" })).reason);"""
IN_WORKER = """(key) => new Promise((resolve, reject) => {
  const worker = new Worker("/worker.js", { type: "module" });
  worker.onmessage = ({ data }) => resolve(data);
  worker.onerror = (event) => reject(event.message);
  worker.postMessage(key);
})"""
#: that no other test calibrates
README_CAMERA = "Camera of a README (1234:000b)"
CAMERAS = webcam("C 1", "C 1")


@pytest.fixture(scope="module")
def token(stack: str) -> dict[str, Any]:
    made = httpx.post(f"{stack}/v1/tokens", json={"origins": ["http://localhost"]}, timeout=60)
    made.raise_for_status()
    return made.json()


@pytest.fixture
def quickstart(tmp_path: Path, stack: str, token: dict[str, Any]) -> Iterator[str]:
    (block,) = [block for block in blocks("docs/quickstart.md") if block.language == "html"]
    page = block.code.replace(SITE, stack).replace("cdb_dev_local", token["token"])
    (tmp_path / "index.html").write_text(page)
    with serving(tmp_path) as address:
        yield address.replace("127.0.0.1", "localhost")


def test_quickstart_ends_with_a_known_camera(
    context: BrowserContext, quickstart: str, stack: str, api: httpx.Client
) -> None:
    page = context.new_page()
    errors = uncaught(page)
    page.add_init_script(CAMERAS + BLIND_DETECTOR)
    page.goto(quickstart)
    page.get_by_role("button", name="Open the camera").click()
    expect(page.locator("#answer")).to_contain_text("unknown_camera")
    page.get_by_role("button", name="Calibrate it").click()
    page.wait_for_url(f"{stack}/calibrate/?**", wait_until="commit")
    asked = {name: values[0] for name, values in parse_qs(urlsplit(page.url).query).items()}
    assert asked["return_to"] == quickstart
    key = {"camera": asked["camera"], "platform": asked["platform"], "img_size": [1280, 720]}
    state = capture(api, Truth(), key, seed=3)
    page.goto(f"{stack}/result/?id={state['calibration_id']}&return_to={asked['return_to']}")
    page.locator("#return").click()
    expect(page.locator("#answer")).to_contain_text("camera_matrix")
    answer = json.loads(page.locator("#answer").inner_text())
    assert answer["camera_matrix"] == state["calibration"]["camera_matrix"]
    assert address(page) == quickstart
    status, error, text = page.evaluate(EXPORT, [state["calibration_id"], TOKEN, f"{stack}/v1"])
    assert (status, float(error) < 0.01) == (200, True)
    assert "camera_matrix" in text
    assert errors == []


def test_pages_elsewhere_may_capture_in_chromium_and_in_firefox(
    context: BrowserContext, in_firefox: InFirefox, quickstart: str, stack: str
) -> None:
    function = f"() => ({page_function('capture_elsewhere')})({[stack, TOKEN]!r})"
    page = context.new_page()
    page.goto(quickstart)
    for reason, opened, others in (page.evaluate(function), in_firefox(quickstart, function)):
        assert (reason, opened) == ("unknown_camera", 201)
        assert len(others) == 3
        assert all(400 <= status < 500 for status in others), "refused by the service, not the browser"


@pytest.mark.parametrize("source", ["README.md", "web/sdk/README.md"])
def test_examples_of_readmes_lead_to_the_calibration(
    page: Page, stack: str, tmp_path: Path, source: str
) -> None:
    html = example(source, "html").replace(SITE, stack)
    if source == "web/sdk/README.md":
        install = example(source, "sh").replace(SITE, stack).split()
        (tmp_path / "package.json").write_text("{}")
        subprocess.run([*install, "--silent", "--no-audit", "--no-fund"], cwd=tmp_path, check=True)
        html = html.replace(f"{stack}/sdk/", "./node_modules/calibdb/")
        html = html.replace('"cdb_dev_local"', f'"cdb_dev_local", api: "{stack}/v1"')
    (tmp_path / "index.html").write_text(f"<!doctype html>{NO_ICON}{html}")
    page.add_init_script(webcam(README_CAMERA) + BLIND_DETECTOR)
    with serving(tmp_path) as elsewhere:
        page.goto(elsewhere)
        page.wait_for_url(f"{stack}/calibrate/?**", wait_until="commit")
    asked = parse_qs(urlsplit(page.url).query)
    assert asked["camera"] == [README_CAMERA]
    assert asked["img_size"] == ["1280x720"]


def example(source: str, language: str) -> str:
    """First block of a document in a language."""
    return next(block.code for block in blocks(source) if block.language == language)


def test_a_worker_looks_cameras_up(page: Page) -> None:
    page.route("**/worker.js", lambda route: route.fulfill(body=WORKER, content_type="text/javascript"))
    page.goto(PLAIN)
    key = {"camera": "Nobody's camera", "platform": "X11; Linux x86_64", "img_size": [640, 360], "zoom": 0}
    assert page.evaluate(IN_WORKER, key) == "unknown_camera"


def script(source: str) -> str:
    codes = [block.code for block in blocks(source) if block.language == "js" and block.reason is None]
    assert codes
    return "\n".join([*codes, "globalThis.done = true;"])


def test_javascript_of_documents_runs(context: BrowserContext, stack: str) -> None:
    page = context.new_page()
    errors = uncaught(page)
    page.route("**/v1/lookup", lambda route: route.fulfill(json=EXAMPLES["lookup"]))
    page.route("**/known/**", lambda route: route.fulfill(status=404))
    page.route("**/v1/rigs/*/result", lambda route: route.fulfill(json=EXAMPLES["showRigResult"]))
    page.add_init_script(CAMERAS)
    page.route("**/cameras.json", lambda route: route.fulfill(json=BUNDLE))
    names = ("calibdb", "calibdb/bundle", "calibdb/adapters/three")
    imports = {name: f"/sdk/{name.partition('/')[2] or name}.js" for name in names}
    map_ = f'<script type="importmap">{json.dumps({"imports": imports})}</script>'
    sources = ("docs/quickstart.md", "docs/two-cameras.md", "web/sdk/README.md")
    for index, code in enumerate(map(script, sources)):
        html = f'<!doctype html>{map_}<script type="module">{code.replace(SITE, stack)}</script>'
        page.route(f"**/sample-{index}", partial(send, html))
        page.goto(f"/sample-{index}")
        page.wait_for_function("globalThis.done")
    assert errors == []


def send(html: str, route: Route) -> None:
    route.fulfill(body=html, content_type="text/html")


@pytest.mark.parametrize("tampered", [False, True])
def test_pinned_sdk_runs_unchanged_or_not_at_all(
    context: BrowserContext, stack: str, tmp_path: Path, tampered: bool
) -> None:
    manual = httpx.get(f"{stack}/docs/sdk/").text
    codes = re.findall(r"<pre[^>]*><code>(.*?)</code></pre>", manual, re.DOTALL)
    plain = [unescape(re.sub(r"<[^>]+>", "", code)) for code in codes]
    (pinned,) = [code for code in plain if "importmap" in code]
    said = 'from "calibdb"; globalThis.found = typeof lookup;'
    page_text = pinned.replace(SITE, stack).replace('from "calibdb";', said)
    (tmp_path / "index.html").write_text(f"<!doctype html>{NO_ICON}{page_text}")
    page = context.new_page()
    if tampered:
        changed = (ROOT / "web/sdk/retry.js").read_text() + "// changed"
        headers = {"access-control-allow-origin": "*"}
        page.route(
            "**/sdk/*/retry.js",
            lambda route: route.fulfill(body=changed, content_type="text/javascript", headers=headers),
        )
    with serving(tmp_path) as address:
        with (
            page.expect_console_message(lambda message: "integrity" in message.text)
            if tampered
            else nullcontext()
        ):
            page.goto(address)
        if not tampered:
            until(page, lambda: page.evaluate("globalThis.found"))
        assert page.evaluate("globalThis.found") == (None if tampered else "function")


def test_search_and_calls_with_an_own_token(page: Page, token: dict[str, Any]) -> None:
    page.add_init_script(f"localStorage.setItem('calibdb.tokens', {json.dumps(json.dumps([token]))})")
    page.goto("/docs/")
    page.keyboard.press("/")
    expect(page.get_by_role("searchbox")).to_be_focused()
    page.keyboard.type("origin proof")
    first = page.locator("#results a").first
    expect(first).to_contain_text("token")
    expect(first.locator("mark").first).to_have_text(re.compile("^(origin|proof)", re.IGNORECASE))
    page.keyboard.press("ArrowDown")
    expect(first).to_be_focused()
    page.goto("/docs/reference/lookup/")
    expect(page.locator("[data-fill=token]").first).to_have_text(token["token"])
    trial = page.locator("form[data-operation=lookup]")
    trial.locator("xpath=..").locator("summary").click()
    expect(trial.locator("[name=credential]")).to_have_value(token["token"])
    body = trial.locator("[name=body]")
    asked = json.loads(body.input_value())
    body.fill(json.dumps(asked | {"camera": "Camera that nobody has calibrated (4d31:9a05)"}))
    trial.get_by_role("button", name="Send").click()
    answer = trial.locator(".trial-answer")
    expect(answer).to_contain_text("200")
    expect(answer).to_contain_text("unknown_camera")
    page.locator("label[for=lookup-fetch]").click()
    expect(page.locator("#visitLookup-fetch")).to_be_checked()
