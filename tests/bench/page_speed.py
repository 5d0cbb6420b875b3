"""Time until pages can be used over a slow line, as a deployment serves them.

    make bench DOCS=page-speed

Chromium, an empty cache, 1.6 Mbit/s and 150 ms a round trip (DevTools' throttling), the files of an upload
over HTTP/2 with Brotli, and the API of a local server. A page can be used when its script has run: its
language can be changed in place. The first instruction of a capture is that of the simulated camera.
"""

from __future__ import annotations

import gzip
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from infra.deploy.site import uploads
from tests.helpers.stack.processes import LocalProcess

ROOT = Path(__file__).parents[2]
SERVER = ROOT / "tests/helpers/edge/serve.mjs"
PATHS = ("/", "/calibrate/", "/de/")
CAPTURE = "/calibrate/?virtual=1"
TOKEN = "cdb_dev_local"
TARGET_S = 1.2
VISITS = 5
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


def _certificate(folder: Path) -> tuple[Path, Path]:
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    made = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    files = ["-keyout", str(key), "-out", str(certificate)]
    subprocess.run([*made, *files, "-days", "1", "-subj", "/CN=localhost"], check=True, capture_output=True)
    return key, certificate


@contextmanager
def served() -> Iterator[str]:
    """Serve the files of an upload for the length of the block; yield the address."""
    with tempfile.TemporaryDirectory() as place, LocalProcess(Path(place) / "data") as service:
        folder = Path(place)
        for file in uploads(ROOT / "web", {"api": "/v1", "token": TOKEN}):
            content = gzip.decompress(file.content) if file.content_encoding else file.content
            (folder / "web" / file.key).parent.mkdir(parents=True, exist_ok=True)
            (folder / "web" / file.key).write_bytes(content)
        node = shutil.which("node") or "node"
        command = [node, str(SERVER), str(folder / "web"), *map(str, _certificate(folder)), service.url]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout
            yield f"https://localhost:{server.stdout.readline().strip()}"
            server.terminate()


def visit(browser: Browser, address: str, event: str = "usable") -> tuple[float, float]:
    """Return the seconds until a page can be used, or instructs, and how far it has shifted."""
    context = browser.new_context(ignore_https_errors=True, service_workers="block")
    page = context.new_page()
    page.add_init_script(READY)
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.emulateNetworkConditions", LINE)
    page.goto(address, wait_until="load")
    time: float = page.wait_for_function(f"window.{event}").json_value()
    shift = page.evaluate("window.shift ?? 0")
    context.close()
    return time / 1000, shift


def main() -> None:
    with served() as site, sync_playwright() as playwright:
        path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
        browser = playwright.chromium.launch(
            executable_path=path, args=["--no-sandbox", "--disable-gpu", "--ignore-certificate-errors"]
        )
        visit(browser, site + PATHS[0])  # compresses the files, starts the browser's processes
        for each in PATHS:
            measured = [visit(browser, site + each) for _ in range(VISITS)]
            times = sorted(time for time, _ in measured)
            within = sum(time <= TARGET_S for time in times)
            print(
                f"{each}: usable in {statistics.median(times):.2f} s (worst {times[-1]:.2f}), "
                f"within {TARGET_S} s in {within} of {VISITS}; layout shift {max(s for _, s in measured):.3f}"
            )
        visit(browser, site + CAPTURE, "instructed")
        times = sorted(visit(browser, site + CAPTURE, "instructed")[0] for _ in range(VISITS))
        print(f"{CAPTURE}: first instruction after {statistics.median(times):.2f} s (worst {times[-1]:.2f})")
        browser.close()


if __name__ == "__main__":
    main()
