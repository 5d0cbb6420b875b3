"""The status page."""

import json

from playwright.sync_api import BrowserContext, Route, expect

from tests.helpers.browser.pictures import picture


def test_what_is_down_is_said_and_what_works_has_its_latency(context: BrowserContext) -> None:
    page = context.new_page()
    parts = [
        {
            "part": name,
            "ok": name != "table",
            "latency_ms": None if name == "table" else 4.0,
            "limit_ms": 2000,
        }
        for name in ("table", "bucket", "edge", "solver")
    ]
    failed = json.dumps({"status": 503, "checked_at": 0, "parts": parts, "canary": None})

    def answer(route: Route) -> None:
        route.fulfill(status=503, body=failed, content_type="application/problem+json")

    page.route("**/healthz?deep=1", answer)
    page.goto("/status/")
    expect(page.locator("#verdict")).to_have_text("A part of the service fails.")
    expect(page.locator("#part-table .state")).to_have_text("fails")
    expect(page.locator("#part-bucket .state")).to_have_text("operational")
    picture(page, "status-down", ["hand"], full=True)
    page.unroute("**/healthz?deep=1")
    page.locator("#again").click()
    expect(page.locator("#verdict")).to_have_text("Everything works.")
    expect(page.locator(".state.ok")).to_have_count(6)
    expect(page.locator("#part-solver td").last).to_contain_text("ms")
    context.set_offline(offline=True)
    expect(page.locator("#verdict")).to_have_text("calibDB cannot be reached.")
    expect(page.locator("#advice")).to_contain_text("Your device has no network")
    context.set_offline(offline=False)
    expect(page.locator("#verdict")).to_have_text("Everything works.")
