"""The SDK as a package, in a worker, and for AR.js."""

import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.captures import capture
from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scripts import PLAIN
from tests.helpers.browser.specimens import answer
from tests.helpers.browser.truth import SMALL

from ..conftest import THOROUGH
from .conftest import ROOT
from .test_ar import SMALL_WEBCAM

KEY = {"camera": "SDK Test Camera (1234:0007)", "platform": "X11; Linux x86_64", "img_size": SMALL.size}
WORKER = """import { lookup } from "/sdk/calibdb.js";
onmessage = async ({ data }) => {
  const { calibration, reason } = await lookup(data, { token: "cdb_dev_local" });
  postMessage({ reason, pixel: calibration?.project([0.1, 0, 1]) ?? null });
};"""
IN_WORKER = """(key) => new Promise((resolve, reject) => {
  const worker = new Worker("/lookup-worker.js", { type: "module" });
  worker.onmessage = ({ data }) => resolve(data);
  worker.onerror = (event) => reject(event.message);
  worker.postMessage(key);
})"""


@pytest.fixture
def project(tmp_path: Path, stack: str) -> Iterator[str]:
    manual = (ROOT / "web/sdk/README.md").read_text().replace("http://127.0.0.1:8000", stack)
    install = re.search(r"```sh\n(npm install .*?)\n```", manual)
    example = re.search(r"```html\n(.*?)```", manual, re.DOTALL)
    assert install is not None
    assert example is not None
    (tmp_path / "package.json").write_text("{}")
    options = ["--silent", "--no-audit", "--no-fund"]
    subprocess.run([*install[1].split(), *options], cwd=tmp_path, check=True)
    imports = {"imports": {"calibdb": "./node_modules/calibdb/calibdb.js"}}
    importmap = f'<script type="importmap">{json.dumps(imports)}</script>'
    page = example[1].replace(f"{stack}/sdk/calibdb.js", "calibdb")
    page = page.replace('"cdb_dev_local"', f'"cdb_dev_local", api: "{stack}/v1"')
    (tmp_path / "index.html").write_text(f'<!doctype html><link rel="icon" href="data:,">{importmap}{page}')
    with serving(tmp_path) as address:
        yield address


def test_the_packages_example_runs(camera_page: Page, project: str, stack: str) -> None:
    camera_page.goto(project)
    camera_page.wait_for_url(f"{stack}/calibrate/?**", wait_until="commit")
    assert parse_qs(urlsplit(camera_page.url).query)["camera"][0].startswith("fake_device")


def test_a_worker_asks_with_what_it_was_told(page: Page) -> None:
    page.route(
        "**/lookup-worker.js", lambda route: route.fulfill(body=WORKER, content_type="text/javascript")
    )
    page.goto(PLAIN)
    found = page.evaluate(IN_WORKER, {**KEY, "zoom": 0, "camera": "A camera that nobody has"})
    assert found == {"reason": "unknown_camera", "pixel": None}


@pytest.fixture(scope="module")
def measured(api: httpx.Client) -> dict[str, Any]:
    return capture(api, SMALL, KEY, seed=11)


def test_the_page_for_ar_js_gives_the_cameras_own_file(
    page: Page, api: httpx.Client, measured: dict[str, Any]
) -> None:
    stored = api.get(f"/calibrations/{measured['calibration_id']}").json()
    answer(page, "**/v1/lookup", lambda: stored | {"calibrations": 5, "reliable": True, "exact_size": True})
    page.add_init_script(SMALL_WEBCAM)
    page.goto("/examples/arjs/")
    page.locator("#start").click()
    page.locator("#ready").wait_for()
    with page.expect_download() as download:
        page.locator("#file").click()
    assert download.value.suggested_filename == "camera_para.dat"
    assert Path(download.value.path()).stat().st_size == 176
    assert page.locator("#error").text_content()
    if THOROUGH:
        picture(page, "example-arjs", ["hand"], full=True)
