"""`python -m infra.tools.conformance`: the storage tests against an independent implementation of AWS.

moto stands in for AWS wherever tests run. Where moto is more lenient than AWS, tests would not notice;
ministack is another program by other people. It runs in an environment of its own, on the loopback
interface, for as long as the tests do.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_SERVER = ROOT / ".build" / "ministack" / "bin" / "hypercorn"
_TESTS = (
    "tests/unit/service/test_store.py",
    "tests/unit/service/test_store_of_cameras.py",
    "tests/unit/service/test_names.py",
)
_PATIENCE = 30.0  # s


def main() -> int:
    """Run the tests against the server; return pytest's status."""
    port = _free_port()
    environment = {**os.environ, "GATEWAY_PORT": str(port), "MINISTACK_PORT": str(port)}
    environment.pop("PYTHONPATH", None)
    command = [str(_SERVER), "--bind", f"127.0.0.1:{port}", "--log-level", "error", "ministack.app:app"]
    server = subprocess.Popen(command, env=environment, cwd=_SERVER.parent)  # noqa: S603 - our own command
    try:
        if not _answers(port):
            print("calibDB: ministack does not answer", file=sys.stderr)
            return 1
        tests = [sys.executable, "-m", "pytest", "-q", *_TESTS]
        elsewhere = {**os.environ, "CONFORMANCE_ENDPOINT": f"http://127.0.0.1:{port}"}
        return subprocess.run(tests, cwd=ROOT, env=elsewhere, check=False).returncode  # noqa: S603
    finally:
        server.terminate()
        server.wait()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _answers(port: int) -> bool:
    end = time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return True
        time.sleep(0.1)
    return False


if __name__ == "__main__":
    sys.exit(main())
