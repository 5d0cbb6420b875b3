"""Lookups by pages: from calibrations made there to an answer for everybody."""

from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
from playwright.sync_api import Page, expect

from calibdb.store.aliases import alias_digest
from tests.helpers.browser.captures import agreed, capture
from tests.helpers.browser.truth import Truth
from tests.helpers.service.client import until


def expect_known_after_five(
    page: Page, api: httpx.Client, stack: str, first: dict[str, Any], truth: Truth
) -> None:
    """Capture with a page's key until its camera is known, and ask for it in every way."""
    key = {name: first[name] for name in ("camera", "platform", "img_size", "zoom")}
    for seed in range(3):
        capture(api, truth, key, seed)

    # Four are too few: the answer leads to the guidance page, which knows what camera it is about.
    answer = api.post("/lookup", json=key)
    assert answer.status_code == 307
    location = answer.headers["location"]
    assert urlsplit(location).path == "/calibrate/"
    assert parse_qs(urlsplit(location).query)["camera"] == [key["camera"]]
    page.goto(location)
    wanted = page.locator("#wanted")
    expect(wanted).to_contain_text(key["camera"])
    w, h = truth.size
    expect(wanted).to_contain_text(f"{w}\u00a0×\u00a0{h}")

    # A browser that navigates to the lookup is taken there.
    query = {
        "camera": key["camera"],
        "platform": key["platform"],
        "img_size": f"{w}x{h}",
        "key": "cdb_dev_local",
    }
    page.goto(str(httpx.URL(f"{stack}/v1/lookup", params=query)))
    page.locator("#wanted").wait_for()
    assert urlsplit(page.url).path == "/calibrate/"

    # The fifth makes it an answer, as soon as the consensus is computed.
    assert capture(api, truth, key, 3)["status"] == "converged"
    known = agreed(api, key)
    assert known["reliable"] is True
    found = page.evaluate(
        """async (key) => (await import("/sdk/calibdb.js")).lookup(key, { token: "cdb_dev_local" })""", key
    )
    calibration = found["calibration"]
    assert calibration == known
    assert calibration["calibrations"] == 5
    assert calibration["exact_size"] is True
    assert abs(calibration["camera_matrix"][0][0] / truth.fx - 1) < 0.005
    assert found["guidanceUrl"] is None

    # While the service fails, the cached lookup answers for this camera, and says of others that it cannot.
    path = f"known/v1/{alias_digest(key['camera'], key['platform'])}/{w}x{h}/0/rectilinear.json"
    until(lambda: httpx.get(f"{stack}/{path}").status_code == 200, 90)
    page.route(
        "**/v1/lookup", lambda route: route.fulfill(status=503, json={"detail": "Service Unavailable"})
    )
    asked = """async (key) => {
      const { lookup } = await import("/sdk/calibdb.js");
      const options = { token: "cdb_dev_local", cache: null, retries: 0 };
      const error = await lookup({ ...key, camera: "Nobody's X9" }, options).catch(({ message }) => message);
      return [(await lookup(key, options)).calibration, error];
    }"""
    calibration, error = page.evaluate(asked, key)
    assert calibration == known
    assert "cannot be asked now" in error
    page.unroute_all()
