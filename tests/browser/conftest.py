"""Real browsers against the whole stack, run as its users run it."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Page,
    Playwright,
    ViewportSize,
    expect,
    sync_playwright,
)

from tests.helpers.browser.firefox import InFirefox, firefox
from tests.helpers.browser.waiting import TIMEOUT_S
from tests.helpers.stack.processes import LocalProcess

ROOT = Path(__file__).parents[2]
OUTPUT = Path(__file__).parent / "output"
TOKEN = "cdb_dev_local"
WINDOW = ViewportSize(width=800, height=600)  # small: who draws in software pays for each pixel
UNKEPT = "Service Worker registration blocked by Playwright"
STALL = "GPU stall due to ReadPixels"  # what a GPU made of software says when its picture is taken
CHROMIUM = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-gpu-watchdog",  # who draws in software may take long
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

#: context of a visitor of some kind: options of `Browser.new_context`
Visitor = Callable[..., BrowserContext]

expect.set_options(timeout=1000 * TIMEOUT_S)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


def chromium_path() -> str | None:
    """Path of the system's Chromium, if possible its headless shell, which opens a page three times as fast.

    None: Playwright's own.
    """
    return shutil.which("chromium-headless-shell") or shutil.which("chromium")


@pytest.fixture(scope="session")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with LocalProcess(tmp_path_factory.mktemp("stack") / "data", {"NEW_TOKENS": "100"}) as server:
        yield server.url


@pytest.fixture(scope="session")
def api(stack: str) -> Iterator[httpx.Client]:
    """The HTTP API with the development token."""
    # Tests ask seldom: a server may close a kept connection in the very moment in which it is used again.
    with httpx.Client(
        base_url=f"{stack}/v1",
        headers={"authorization": f"Bearer {TOKEN}"},
        timeout=60,
        limits=httpx.Limits(max_keepalive_connections=0),
    ) as client:
        yield client


@pytest.fixture(scope="session")
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def chromium(playwright: Playwright) -> Iterator[Browser]:
    browser = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def in_firefox() -> Iterator[InFirefox]:
    """Evaluator of functions in pages of one Firefox, each page a visit of its own.

    The names of tests that take it contain `in_firefox`: one worker runs them all.
    """
    with firefox() as evaluate:
        yield evaluate


def close(context: BrowserContext) -> None:
    for page in context.pages:
        page.unroute_all(behavior="ignoreErrors")
    context.unroute_all(behavior="ignoreErrors")
    context.close()


@pytest.fixture
def visitor(chromium: Browser, stack: str) -> Iterator[Visitor]:
    """Opener of contexts that end with the test."""
    contexts: list[BrowserContext] = []

    def opened(**kind: object) -> BrowserContext:
        # Without the service worker, which has tests of its own: what it answers, routes do not see. Without
        # motion, unless a test asks for it: the processor draws each frame.
        still = {"service_workers": "block", "reduced_motion": "reduce"}
        options = {"base_url": stack, "viewport": WINDOW} | still | kind
        contexts.append(chromium.new_context(**options))  # type: ignore[arg-type]
        contexts[-1].set_default_timeout(1000 * TIMEOUT_S)
        return contexts[-1]

    yield opened
    for context in contexts:
        close(context)


@pytest.fixture
def context(visitor: Visitor) -> BrowserContext:
    return visitor()


@pytest.fixture
def page(context: BrowserContext) -> Iterator[Page]:
    """A page that must not complain: console errors, uncaught errors, policy violations fail the test."""
    complaints: list[str] = []

    def heard(message: ConsoleMessage) -> None:
        # The SDK asks for an answer at the edge that may not be there; browsers write down every 404.
        missing = "/known/" in message.location.get("url", "") or (
            "/v1/lookup" in message.location.get("url", "") and "503" in message.text
        )
        harmless = message.text == UNKEPT or STALL in message.text or missing
        if message.type in {"error", "warning"} and not harmless:
            complaints.append(f"{message.type}: {message.text} {message.location.get('url', '')}")

    page = context.new_page()
    page.on("console", heard)
    page.on("pageerror", lambda error: complaints.append(f"uncaught: {error}"))
    yield page
    assert complaints == []
