"""Files that are late or missing."""

from playwright.sync_api import BrowserContext, Page, Route, expect

from tests.helpers.browser.scenes import webcam
from tests.helpers.browser.waiting import until


def test_missing_detector_is_explained(context: BrowserContext) -> None:
    page = context.new_page()
    page.route("**/*.wasm", lambda route: route.abort())
    page.add_init_script(webcam())
    page.goto("/calibrate/")
    page.locator("#start").click()
    page.locator(
        "#failure", has_text="The board detector could not be loaded. Check the connection"
    ).wait_for()


def test_missing_settings_are_explained(context: BrowserContext) -> None:
    page = context.new_page()
    page.route("**/config.json", lambda route: route.abort())
    page.goto("/")
    page.locator("#look").click()
    page.locator("#outcome p", has_text="calibDB cannot be reached. Check the connection").wait_for()


def test_clicks_before_the_scripts_count(page: Page) -> None:
    pages = (
        # (page, its module, form to send or button to click, what then is there)
        ("/examples/arjs/", "**/examples/arjs/main.js", "#start", "#problem:not([hidden])"),
        (
            "/docs/reference/lookup/",
            "**/docs/*.js",
            "form[data-operation=lookup] button",
            ".trial-answer:not(:empty)",
        ),
    )
    page.add_init_script(
        "navigator.mediaDevices.getUserMedia = async () => { throw new DOMException('', 'NotFoundError'); }"
    )
    for address, module, button, there in pages:
        click_while_held(page, address, module, button)
        page.locator(there).first.wait_for(state="attached")
        assert page.url.endswith(address)


def test_a_file_chosen_before_the_scripts_is_read(page: Page) -> None:
    held: list[Route] = []
    page.route("**/import/main.js", lambda route: held.append(route))
    page.goto("/import/", wait_until="commit")
    page.locator("#file").set_input_files({"name": "a.json", "mimeType": "", "buffer": b"no calibration"})
    until(page, lambda: held)
    held[0].continue_()
    expect(page.locator("#file-state")).to_have_text("1 file chosen")
    expect(page.locator("#status")).to_contain_text("a.json")


def click_while_held(page: Page, address: str, module: str, button: str) -> None:
    held: list[Route] = []
    clicked = False
    page.route(module, lambda route: route.continue_() if clicked else held.append(route))
    page.goto(address, wait_until="commit")
    page.locator(button).first.evaluate("button => button.click()")
    until(page, lambda: held)
    clicked = True
    for route in held:
        route.continue_()
