"""The README's example as it stands, on a page of another origin, with the browser's own made-up camera."""

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Playwright

from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.waiting import TIMEOUT_S

from .conftest import CHROMIUM, ROOT, chromium_path

FAKE_CAMERA = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]


@pytest.fixture
def elsewhere(tmp_path: Path, stack: str) -> Iterator[str]:
    """Address of a page on another port, another origin, that holds the README's example."""
    example = re.search(r"```html\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert example is not None
    page = example[1].replace("http://127.0.0.1:8000", stack)
    (tmp_path / "index.html").write_text(f'<!doctype html><link rel="icon" href="data:,">{page}')
    with serving(tmp_path) as address:
        yield address


def test_the_readmes_example_runs_on_another_origin(
    playwright: Playwright, elsewhere: str, stack: str
) -> None:
    browser = playwright.chromium.launch(executable_path=chromium_path(), args=[*CHROMIUM, *FAKE_CAMERA])
    page = browser.new_page(service_workers="block")
    page.set_default_timeout(1000 * TIMEOUT_S)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(elsewhere)
    page.wait_for_url(f"{stack}/calibrate/?**")
    asked = parse_qs(urlsplit(page.url).query)
    assert asked["camera"][0].startswith("fake_device")
    assert asked["img_size"] == ["640x480"]
    assert errors == []
    browser.close()
