"""The detector in its worker."""

import numpy as np
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.marks import thorough

WATCH = page_function("watch_detector")


@pytest.mark.parametrize("frames", [20, *thorough(2_000)])
def test_detector_is_exact_and_keeps_its_memory(page: Page, frames: int) -> None:
    page.goto(PLAIN)
    seen = page.evaluate(WATCH, frames)
    assert seen["full"]["ids"] == list(range(40))
    errors = np.linalg.norm(np.array(seen["full"]["points"]) - np.array(seen["truth"]), axis=1)
    rms = np.sqrt((errors**2).mean())
    assert rms < 0.1
    assert errors.max() < 0.3
    assert seen["memory"][-1] == seen["memory"][0], f"grows by {np.diff(seen['memory']).sum()} bytes"
    assert (seen["empty"]["ids"], seen["empty"]["markers"]) == ([], 0)
    assert seen["progress"][-1] == 1.0
    assert seen["progress"] == sorted(seen["progress"])
