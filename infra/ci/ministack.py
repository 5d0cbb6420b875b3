"""ministack, an implementation of AWS independent of the one in the tests, on the loopback interface.

`python -m infra.ci.ministack COMMAND` runs a command with the server's address in CONFORMANCE_ENDPOINT.
"""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_SERVER = Path(__file__).resolve().parents[2] / ".build" / "ministack" / "bin" / "hypercorn"
_START_TIMEOUT_S = 30.0  # s


@contextmanager
def serving() -> Iterator[str]:
    """Run the server within the block and yield its address; raises RuntimeError if it does not answer."""
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    environment = {**os.environ, "GATEWAY_PORT": str(port), "MINISTACK_PORT": str(port)}
    environment.pop("PYTHONPATH", None)
    command = [str(_SERVER), "--bind", f"127.0.0.1:{port}", "--log-level", "error", "ministack.app:app"]
    with (_SERVER.parent / "ministack.log").open("w") as log:
        server = subprocess.Popen(command, env=environment, cwd=_SERVER.parent, stdout=log, stderr=log)
        try:
            _answers(port, server)
            yield f"http://127.0.0.1:{port}"
        finally:
            server.terminate()
            server.wait()


def _answers(port: int, server: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + _START_TIMEOUT_S
    while time.monotonic() < end and server.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise RuntimeError("ministack does not answer")


if __name__ == "__main__":
    with serving() as endpoint:
        elsewhere = {**os.environ, "CONFORMANCE_ENDPOINT": endpoint}
        sys.exit(subprocess.run(sys.argv[1:], env=elsewhere, check=False).returncode)
