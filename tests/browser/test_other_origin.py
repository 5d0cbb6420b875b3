"""The README's example on another origin."""

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Page

from tests.helpers.browser.elsewhere import serving

from .conftest import ROOT


@pytest.fixture
def elsewhere(tmp_path: Path, stack: str) -> Iterator[str]:
    example = re.search(r"```html\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert example is not None
    page = example[1].replace("http://127.0.0.1:8000", stack)
    (tmp_path / "index.html").write_text(f'<!doctype html><link rel="icon" href="data:,">{page}')
    with serving(tmp_path) as address:
        yield address


def test_the_readmes_example_runs_on_another_origin(camera_page: Page, elsewhere: str, stack: str) -> None:
    camera_page.goto(elsewhere)
    camera_page.wait_for_url(f"{stack}/calibrate/?**", wait_until="commit")
    asked = parse_qs(urlsplit(camera_page.url).query)
    assert asked["camera"][0].startswith("fake_device")
    assert asked["img_size"] == ["640x480"]
