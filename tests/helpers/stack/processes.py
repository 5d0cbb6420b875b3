"""The local stack as a process of its own, to be started, killed and started again."""

import os
import re
import signal
import subprocess
import sys
import sysconfig
import threading
import time
import venv
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Self

import httpx

ROOT = Path(__file__).resolve().parents[3]


def without_checkout(environment: Mapping[str, str]) -> dict[str, str]:
    """Environment by which no Python finds this checkout; compiled modules stay where they are."""
    hidden = ("CALIBDB", "PYTHON")
    return {
        name: value
        for name, value in environment.items()
        if not name.startswith(hidden) or name == "PYTHONPYCACHEPREFIX"
    }


def environment_of(root: Path, *wheels: Path, startup: str = "") -> Path:
    """Install wheels into a new environment with the third-party packages of this one.

    Returns the folder of its programs. `startup`: a line that its Python executes first.
    """
    venv.create(root / "venv", with_pip=False)
    scripts = root / "venv" / "bin"
    python = scripts / "python"
    uv = Path(sys.executable).with_name("uv")
    if uv.exists():  # takes an eighth of pip's time
        install = [uv, "pip", "install", "--python", python]
    else:
        install = [sys.executable, "-m", "pip", "--python", python, "install", "--no-compile"]
    subprocess.run([*install, "--quiet", "--no-index", "--no-deps", *wheels], check=True)
    (packages,) = (root / "venv" / "lib").glob("python*/site-packages")
    (packages / "third-party.pth").write_text(f"{sysconfig.get_path('purelib')}\n{startup}\n")
    return scripts


def run_installed(*command: str | Path, folder: Path) -> str:
    """Run a program that finds no checkout; return what it prints."""
    variables = without_checkout(os.environ)
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


class LocalProcess:
    """`python -m infra.server` on a free port, ready when the block begins; killed when it ends.

    `program`: an installed server, which gets nothing of this checkout. `start_seconds`: until it answered
    its health check.
    """

    def __init__(
        self, data_dir: Path, environment: Mapping[str, str] | None = None, program: Path | None = None
    ) -> None:
        self._data_dir = data_dir
        self._environment = {"PORT": "0", "DATA_DIR": str(data_dir), **(environment or {})}
        self._program = program

    def __enter__(self) -> Self:
        started = time.monotonic()
        self.log = self._data_dir.parent / f"{self._data_dir.name}.log"
        if self._program:
            command = [self._program]
            variables = without_checkout(os.environ)
        else:
            command = [sys.executable, "-m", "infra.server"]
            variables = os.environ | {"PYTHONPATH": "layers/service:layers/solver:."}
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                command,
                cwd=self._data_dir.parent if self._program else ROOT,
                env=variables | self._environment,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                start_new_session=True,
            )
        watchdog = threading.Timer(180, self.process.kill)
        watchdog.start()
        line = self.process.stdout.readline()
        watchdog.cancel()
        found = re.search(r"http://127\.0\.0\.1:\d+", line)
        if not found:
            self.__exit__()
            raise RuntimeError(f"the server did not start: {self.log.read_text()[-2000:]}")
        self.url = found[0]
        assert httpx.get(f"{self.url}/healthz", timeout=60).status_code == 200
        self.start_seconds = time.monotonic() - started
        return self

    def kill(self) -> None:
        with suppress(ProcessLookupError):  # it has ended
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def stop(self, timeout_s: float = 60) -> int:
        """Ask it to end; return its exit status."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout_s)

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.kill()
        self.process.stdout.close()
