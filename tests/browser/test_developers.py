"""Tokens and snippets of the page for developers."""

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.captures import calibrated
from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.pictures import WIDE, picture
from tests.helpers.browser.scenes import BLIND_DETECTOR, LABEL, webcam
from tests.helpers.browser.truth import Truth
from tests.helpers.browser.waiting import passing, until

MAX_ACTIONS = 8
KEY = {"camera": LABEL, "platform": "X11; Linux x86_64", "img_size": [1280, 720]}


# The event that removes a question comes later than its closing.
ASK_TWICE = """async () => {
  const { askConfirmation } = await import("/developers/confirmation.js");
  const question = { heading: "Revoke?", text: "For good.", yes: "Revoke for good" };
  const first = askConfirmation(question);
  document.querySelector("dialog").close();
  const second = askConfirmation(question);
  const count = document.querySelectorAll("dialog").length;
  document.querySelector("dialog button[value=yes]").click();
  return [count, await first, await second, document.querySelectorAll("dialog").length];
}"""


@pytest.fixture(scope="module")
def known(api: httpx.Client) -> dict[str, Any]:
    return calibrated(api, Truth(), KEY)


def test_from_landing_page_to_lookup_elsewhere(
    context: BrowserContext, stack: str, known: dict[str, Any], tmp_path: Path
) -> None:
    context.grant_permissions(["clipboard-read", "clipboard-write"], origin=stack)
    page = context.new_page()
    page.add_init_script(webcam() + BLIND_DETECTOR)
    done = ["open the landing page"]

    def click(selector: str) -> None:
        done.append(f"click {selector}")
        page.locator(selector).first.click()

    page.goto(stack)
    click('a[href$="developers/"]')
    click("#make-button")
    expect(page.locator("#token-heading")).to_be_focused()
    with passing(page, "#copy-snippet", "Copied ✓"):
        click("#copy-snippet")
    copied = page.evaluate("navigator.clipboard.readText()")
    (made,) = page.evaluate("JSON.parse(localStorage['calibdb.tokens'])")
    done.append("save the code as index.html")
    (tmp_path / "index.html").write_text(copied.replace("<title>", '<link rel="icon" href="data:,"><title>'))
    with serving(tmp_path) as address:
        own = address.replace("127.0.0.1", "localhost").rstrip("/")
        done.append("open it from a server of one's own")
        page.goto(own)
        done.append("allow the camera")
        expect(page.locator("#answer")).to_contain_text('"camera_matrix"')
        assert len(done) <= MAX_ACTIONS, done
        found = json.loads(page.locator("#answer").text_content() or "")
        assert found["camera_matrix"] == known["camera_matrix"]
        assert found["reliable"]
        # The token is good on this origin, whoever answered, and on no other.
        ask = """async ([api, token]) => {
          const response = await fetch(`${api}/v1/usage`, {headers: {authorization: `Bearer ${token}`}});
          return [response.status, (await response.json()).plan];
        }"""
        assert page.evaluate(ask, [stack, made["token"]]) == [200, "trial"]
        page.evaluate("sessionStorage.clear()")
        page.goto(f"{address}not-there")
        assert page.evaluate(ask, [stack, made["token"]]) == [403, None]
        page.add_init_script(webcam("New One"))
        page.goto(f"{own}/?again")
        expect(page.locator("#answer")).to_have_text("calibDB does not know New One yet.")
        page.locator("#calibrate").click()
        page.wait_for_url(
            re.compile(re.escape(f"{stack}/calibrate/?") + r".*return_to=http%3A%2F%2Flocalhost"),
            wait_until="commit",
        )
        page.goto(f"{own}/#calibration={known['id'] or ''}")
        expect(page.locator("#answer")).to_contain_text('"camera_matrix"')


def test_token_is_kept_and_managed_and_works_with_curl(
    page: Page, known: dict[str, Any], tmp_path: Path
) -> None:
    page.goto("/developers/")
    page.locator("#origins").fill("http://example.org")
    page.locator("#make-button").click()
    expect(page.locator("#origins-problem")).to_contain_text("must begin with https://")
    expect(page.locator("#origins")).to_be_focused()
    page.locator("#origins").fill("localhost https://nobody.invalid/page")
    page.keyboard.press("Enter")
    expect(page.locator("#token-facts")).to_contain_text("trial")
    expect(page.locator(".proof-line")).to_have_text(re.compile("calibdb-site-verification=[0-9a-f]{16}"))
    page.locator("#verify").click()
    expect(page.locator(".origins .problem")).to_have_text(
        "The domain name has no address. Check its spelling."
    )
    expect(page.locator("#snippet")).to_contain_text("/sdk/calibdb.js")
    picture(page, "developers", full=True)
    page.set_viewport_size({"width": 320, "height": 700})
    assert page.evaluate(WIDE) == 0
    page.locator("#snippet-curl").click()
    line = page.locator("#snippet").text_content()
    assert line
    sent = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=True, timeout=60)
    assert json.loads(sent.stdout)["camera"] == known["camera"]
    assert json.loads(sent.stdout)["reliable"]

    def stored() -> Any:
        return page.evaluate("JSON.parse(localStorage['calibdb.tokens'])")

    (made,) = stored()
    assert made.keys() == {"id", "token", "management_token", "name", "origins", "api"}
    page.locator("#token-name").fill("My <site>")
    page.locator("#token-name").press("Enter")
    expect(page.locator("#token-heading")).to_have_text("My <site>")
    page.locator("#grace").select_option("0")
    page.locator("#rotate").click()
    expect(page.locator("#token-status")).to_contain_text("This is the new secret")
    (rotated,) = stored()
    assert rotated["token"] != made["token"]
    page.reload()
    expect(page.locator("#secret-api_token")).to_have_text(rotated["token"])
    expect(page.locator("#secret-management_token")).not_to_contain_text(made["management_token"])
    with page.expect_download() as saved:
        page.locator("#export").click()
    saved.value.save_as(tmp_path / "tokens.json")
    page.locator("#forget").click()
    page.locator("dialog button", has_text="Remove").click()
    expect(page.locator("#making")).to_be_focused()
    assert stored() == []
    page.locator("#import").set_input_files(tmp_path / "tokens.json")
    expect(page.locator("#kept-status")).to_have_text("1 token loaded.")
    assert stored() == [rotated | {"name": "My <site>"}]
    expect(page.locator("#token-facts")).to_be_visible()
    page.locator("#revoke").focus()
    page.keyboard.press("Enter")
    expect(page.locator("dialog")).to_contain_text("cannot be undone")
    page.keyboard.press("Escape")
    expect(page.locator("#revoke")).to_be_focused()
    assert len(stored()) == 1
    page.keyboard.press("Enter")
    page.locator("dialog button", has_text="Revoke for good").click()
    expect(page.locator("#token-status")).to_have_text("“My <site>” is revoked.")
    assert stored() == []
    assert page.evaluate(ASK_TWICE) == [1, False, True, 0], (
        "a closed question is gone before the next is asked"
    )


def expect_refusal(page: Page, words: str) -> None:
    complaint = page.locator("#made")
    page.locator("#make-button").click()
    expect(complaint).to_contain_text(words)


def test_refusals_are_explained_and_unkept_secrets_warn(context: BrowserContext) -> None:
    page = context.new_page()
    problem = {
        "title": "Quota used up",
        "status": 429,
        "detail": "At most 5.",
        "type": "/docs/problems/#quota",
    }
    page.route(
        "**/v1/tokens",
        lambda route: route.fulfill(
            status=429,
            body=json.dumps(problem),
            headers={"retry-after": "7300", "content-type": "application/problem+json"},
        ),
    )
    page.goto("/developers/?lang=de")
    expect_refusal(page, "Sie endet in etwa 3 Stunden")
    page.locator("#language").select_option("en")
    expect(page.locator("#made")).to_contain_text("It ends in about 3 hours")
    context.set_offline(offline=True)
    page.unroute("**/v1/tokens")
    expect_refusal(page, "calibDB cannot be reached")
    context.set_offline(offline=False)

    page.evaluate("""() => {
      Storage.prototype.setItem = () => { throw new DOMException("full", "QuotaExceededError"); };
    }""")
    page.locator("#make-button").click()
    expect(page.locator("#unkept")).to_be_visible()
    expect(page.locator("#secret-api_token")).to_have_text(re.compile("cdb_"))
    asked: list[str] = []

    def stay(dialog: Any) -> None:
        asked.append(dialog.type)
        dialog.dismiss()

    page.once("dialog", stay)
    page.close(run_before_unload=True)
    until(page, lambda: asked)
    assert asked == ["beforeunload"]
    expect(page.locator("#secret-api_token")).to_be_visible()
