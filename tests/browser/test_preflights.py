"""The client on another origin than the API.

An HTTP API hands preflights to a function whose route matches them, or answers them itself; both are held.
"""

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser

from infra.web_build import site
from tests.aws.emulator import LocalStack
from tests.helpers.browser.captures import capture
from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import TIMEOUT_S
from tests.helpers.marks import thorough
from tests.helpers.stack.faults import watched_requests

from ..conftest import THOROUGH
from .conftest import TOKEN

KEY = {"camera": "Elsewhere (1234:0009)", "platform": "X11; Linux x86_64", "img_size": [1280, 720], "zoom": 0}
CAPTURED = KEY | {"camera": "Elsewhere (1234:000a)", "img_size": SMALL.size}
#: asks for a camera and for a session, and for what needs one, without a board
ADMITTED = """async ([key, token, api]) => {
  const ask = (method, path, bearer) => fetch(`${api}/${path}`, {
    method, headers: { authorization: `Bearer ${bearer}`, "content-type": "application/json" },
    body: method === "POST" && bearer !== token ? "{}" : undefined,
  });
  const { lookup } = await import("/sdk/calibdb.js");
  const { reason } = await lookup(key, { token, api, cache: null });
  const opened = await ask("POST", "auth", token);
  const { session_id } = await opened.json();
  const others = [["POST", "session"], ["GET", "session/pose"], ["POST", "session/views"]];
  const answers = await Promise.all(others.map(([method, path]) => ask(method, path, session_id)));
  return [reason, opened.status, answers.map(({ status }) => status)];
}"""
PREFLIGHTED = {"/v1/auth", "/v1/session", "/v1/session/pose", "/v1/session/views", "/v1/lookup"}
EXPORT = """async ([id, token, api]) => {
  const headers = { authorization: `Bearer ${token}` };
  const response = await fetch(`${api}/calibrations/${id}?format=ros`, { headers });
  return [response.status, response.headers.get("x-conversion-error"), await response.text()];
}"""


@pytest.fixture(params=[*thorough(False), True], ids=["by the function", "by the gateway"])
def stack(request: pytest.FixtureRequest) -> Iterator[LocalStack]:
    with LocalStack(answers_preflights=request.param) as stack:
        yield stack


@pytest.fixture(scope="module")
def site_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    site.main(folder)
    return folder


def test_a_page_of_another_origin_is_admitted_in_chromium_and_in_firefox(
    stack: LocalStack, chromium: Browser, in_firefox: InFirefox, site_folder: Path
) -> None:
    with stack.serve() as url, watched_requests(stack) as preflights:
        api = f"{url}/v1"
        with serving(site_folder, {"api": api, "token": TOKEN}) as origin:
            function = f"() => ({ADMITTED})({[KEY, TOKEN, api]!r})"
            page = chromium.new_page(service_workers="block")
            page.set_default_timeout(1000 * TIMEOUT_S)
            page.goto(f"{origin}board/")
            for reason, opened, others in (page.evaluate(function), in_firefox(f"{origin}board/", function)):
                assert (reason, opened) == ("unknown_camera", 201)
                assert len(others) == 3
                assert all(400 <= status < 500 for status in others), (
                    "refused by the service, not the browser"
                )
            if THOROUGH:
                headers = {"authorization": f"Bearer {TOKEN}"}
                with httpx.Client(base_url=api, headers=headers, timeout=60) as client:
                    identity = capture(client, SMALL, CAPTURED, seed=1)["calibration_id"]
                status, error, text = page.evaluate(EXPORT, [identity, TOKEN, api])
                assert (status, float(error) < 0.01) == (200, True)
                assert "camera_matrix" in text
            page.close()
    assert preflights >= PREFLIGHTED
