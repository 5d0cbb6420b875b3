"""Time until pages can be used over a slow line, as a deployment serves them: `make bench DOCS=page-speed`.

Chromium, an empty cache, 1.6 Mbit/s and 150 ms per round trip (DevTools' throttling), the files of an upload
over HTTP/2 with Brotli, and the API of a local server. A page is usable when its language can be changed in
place. The first instruction of a capture is that of the simulated camera.
"""

import gzip
import statistics
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from infra.deploy.site import uploads
from tests.browser.conftest import CHROMIUM, TOKEN, chromium_path
from tests.helpers.data import ROOT
from tests.helpers.stack.processes import LocalProcess

PAGES = {"/": "usable", "/calibrate/": "usable", "/de/": "usable", "/calibrate/?virtual=1": "instructed"}
SERVER = ROOT / "tests/helpers/edge/serve.mjs"
CERTIFY = (
    "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 1 -subj /CN=localhost"
)
VISITS = 5
TIMEOUT_MS = 120_000
LINE = {"offline": False, "latency": 150, "downloadThroughput": 1.6e6 / 8, "uploadThroughput": 0.75e6 / 8}
READY = """new MutationObserver(() => {
  const select = document.getElementById("language");
  if (select?.dataset.inPlace !== undefined) window.usable ??= performance.now();
  const instruction = document.getElementById("instruction");
  const instructs = instruction?.textContent.trim() && instruction.checkVisibility();
  if (instructs) window.instructed ??= performance.now();
}).observe(document, { subtree: true, childList: true, attributes: true });
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) window.shift = (window.shift ?? 0) + entry.value;
}).observe({ type: "layout-shift", buffered: true });"""


@contextmanager
def served() -> Iterator[str]:
    """Serve the files of an upload in the block; yield the address."""
    with tempfile.TemporaryDirectory() as place, LocalProcess(Path(place, "data")) as service:
        for file in uploads(ROOT / "web", {"api": "/v1", "token": TOKEN}):
            path = Path(place, "web", file.key)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(gzip.decompress(file.content) if file.content_encoding else file.content)
        files = [f"{place}/key.pem", f"{place}/certificate.pem"]
        certify = [*CERTIFY.split(), "-keyout", files[0], "-out", files[1]]
        subprocess.run(certify, check=True, capture_output=True)
        command = ["node", str(SERVER), f"{place}/web", *files, service.url]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout
            try:
                yield f"https://localhost:{server.stdout.readline().strip()}"
            finally:
                server.terminate()


def visit(browser: Browser, address: str, event: str) -> tuple[float, float]:
    """Seconds until an event in a page, and how far its layout has shifted."""
    context = browser.new_context(ignore_https_errors=True, service_workers="block")
    page = context.new_page()
    page.set_default_timeout(TIMEOUT_MS)
    page.add_init_script(READY)
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.emulateNetworkConditions", LINE)
    page.goto(address, wait_until="load")
    time: float = page.wait_for_function(f"window.{event}").json_value()
    shift: float = page.evaluate("window.shift ?? 0")
    context.close()
    return time / 1000, shift


def main() -> None:
    with served() as site, sync_playwright() as playwright:
        flags = [*CHROMIUM, "--ignore-certificate-errors"]
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=flags)
        visit(browser, site, "usable")  # compresses the files, starts the browser's processes
        for path, event in PAGES.items():
            visits = [visit(browser, site + path, event) for _ in range(VISITS)]
            times, shifts = zip(*visits, strict=True)
            typical = f"{statistics.median(times):.2f} s (worst {max(times):.2f})"
            print(f"{path}: {event} after {typical}; layout shift {max(shifts):.3f}", flush=True)
        browser.close()


if __name__ == "__main__":
    main()
