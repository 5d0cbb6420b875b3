"""The SDK as applications get it: packed and installed, in a worker, and back from the guidance page."""

import json
import os
import re
import subprocess
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from playwright.sync_api import Page, Playwright

from .captures import capture
from .conftest import CHROMIUM, ROOT, executable
from .truth import Truth

FAKE_CAMERA = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
KEY = {"camera": "SDK Test Camera (1234:0007)", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}
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


class Quiet(SimpleHTTPRequestHandler):
    """Keeps its requests to itself."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.fixture
def project(tmp_path: Path, stack: str) -> Iterator[str]:
    """Address of a project that has installed the package, with the example of its README as its page."""
    environment = os.environ | {"PATH": f"{ROOT}/node_modules/.bin:{os.environ['PATH']}"}
    packed = subprocess.run(
        ["npm", "pack", "--json", "--pack-destination", str(tmp_path)],
        cwd=ROOT / "web/sdk", env=environment, check=True, capture_output=True, text=True,
    )  # fmt: skip
    (tmp_path / "package.json").write_text("{}")
    tarball = json.loads(packed.stdout)[0]["filename"]
    subprocess.run(
        ["npm", "install", "--offline", "--silent", "--no-audit", f"./{tarball}"], cwd=tmp_path, check=True
    )
    readme = (tmp_path / "node_modules/calibdb/README.md").read_text()
    example = re.search(r"```html\n(.*?)```", readme, re.DOTALL)
    assert example is not None
    imports = {"imports": {"calibdb": "./node_modules/calibdb/calibdb.js"}}
    importmap = f'<script type="importmap">{json.dumps(imports)}</script>'
    (tmp_path / "index.html").write_text(
        f'<!doctype html><link rel="icon" href="data:,">{importmap}'
        + example[1].replace("http://127.0.0.1:8000", stack)
    )
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}/"
    server.shutdown()
    thread.join()
    server.server_close()


def test_the_packages_example_runs(playwright: Playwright, project: str, stack: str) -> None:
    browser = playwright.chromium.launch(
        executable_path=executable("chromium"), args=[*CHROMIUM, *FAKE_CAMERA]
    )
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(project)
    page.wait_for_url(f"{stack}/calibrate/?**")
    assert parse_qs(urlsplit(page.url).query)["camera"][0].startswith("fake_device")
    assert errors == []
    browser.close()


def test_a_worker_asks_with_what_it_was_told(page: Page) -> None:
    page.route(
        "**/lookup-worker.js", lambda route: route.fulfill(body=WORKER, content_type="text/javascript")
    )
    page.goto("/")
    found = page.evaluate(IN_WORKER, {**KEY, "zoom": 0, "camera": "A camera that nobody has"})
    assert found == {"reason": "unknown_camera", "pixel": None}


def test_the_result_comes_back_to_the_application(page: Page, api: httpx.Client, stack: str) -> None:
    state = capture(api, Truth(), KEY, seed=11)
    page.goto("/board/")  # stands for an application: same origin, nothing of the result page
    back = f"{stack}/board/?from=result"
    page.goto(f"/result/?id={state['calibration_id']}&return_to={back}")
    page.locator("#return").click()
    page.wait_for_url(f"{back}#calibration=*")
    found = page.evaluate(
        """async () => {
          const { calibrate } = await import("/sdk/calibdb.js");
          const calibration = await calibrate({ token: "cdb_dev_local" });
          const { id, camera_matrix: matrix } = calibration;
          return { id, matrix, pixel: calibration.project([0, 0, 1]), href: location.href };
        }"""
    )
    matrix = state["calibration"]["camera_matrix"]
    assert found["matrix"] == matrix
    assert found["pixel"] == pytest.approx([matrix[0][2], matrix[1][2]])
    assert found["id"] == state["calibration_id"]
    assert found["href"] == back
