"""Vulnerability audit of the lock files: `python -m infra.ci.audit`.

A service of pip-audit or npm that does not respond here is reported, and does not fail the audit.
"""

import json
import re
import subprocess
import sys
import tempfile
import urllib.request
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PIP_AUDIT = "pip-audit==2.10.1"
ASKED = "https://pypi.org/pypi/pip-audit/2.10.1/json"
"""Address of a request that pip-audit makes too, about a package that exists."""
LOCKS = ("requirements.lock", "layers/service/requirements.lock", "layers/solver/requirements.lock")
_AUDIT_TIMEOUT_S = 60.0  # s
_PROBE_TIMEOUT_S = 10.0  # does the service answer at all?
_PIN = re.compile(r"(?m)^([A-Za-z0-9][\w.-]*==[^\s;\\]+)")


class Audit(NamedTuple):
    """Findings of one tool: the number of packages that it could judge, and the vulnerabilities."""

    judged: int
    vulnerable: tuple[str, ...] = ()


def of_pip(answer: Any) -> Audit:
    """Read pip-audit's JSON; what it could not judge has a `skip_reason` instead of `vulns`."""
    judged = [package for package in answer["dependencies"] if "vulns" in package]
    vulnerable = (
        f"{package['name']} {package['version']}: {vulnerability['id']}"
        for package in judged
        for vulnerability in package["vulns"]
    )
    return Audit(len(judged), tuple(vulnerable))


def of_npm(answer: Any) -> Audit:
    """Read npm's JSON, which lacks `metadata` if the registry did not respond."""
    if "metadata" not in answer:
        return Audit(0)
    found = answer.get("vulnerabilities", {}).values()
    severe = (f"{v['name']}: {v['severity']}" for v in found if v["severity"] in ("high", "critical"))
    return Audit(answer["metadata"]["dependencies"]["total"], tuple(severe))


def pins(*locks: Path) -> list[str]:
    """Collect `name==version` of everything the lock files name."""
    return sorted({pin for lock in locks for pin in _PIN.findall(lock.read_text(encoding="utf-8"))})


def python(packages: list[str], asked: str = ASKED) -> Audit:
    """Audit Python's packages. pip-audit is installed if the service responds."""
    folder = ROOT / ".build" / "audit"
    pip_audit = folder / "bin" / "pip-audit"
    try:
        urllib.request.urlopen(asked, timeout=_PROBE_TIMEOUT_S).close()  # noqa: S310 - our own address
        if not pip_audit.exists():
            _run([sys.executable, "-m", "venv", "--without-pip", str(folder)])
            _run([sys.executable, "-m", "pip", "--python", str(folder), "install", "--quiet", PIP_AUDIT])
    except (OSError, subprocess.TimeoutExpired):
        return Audit(0)
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as requirements:
        requirements.write("\n".join(packages))
        requirements.flush()
        command = [str(pip_audit), "--no-deps", "--disable-pip", "--progress-spinner=off", "-f", "json"]
        return of_pip(_answer([*command, "--timeout", "5", "-r", requirements.name]))


def _run(command: list[str]) -> str:
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=_AUDIT_TIMEOUT_S, check=False
    )
    return done.stdout


def _answer(command: list[str]) -> Any:
    try:
        return json.loads(_run(command))
    except (OSError, subprocess.TimeoutExpired, ValueError):
        return {"dependencies": []}


def report(name: str, audit: Audit) -> str:
    """Describe the findings in a line."""
    if not audit.judged:
        return f"{name}: not audited, the vulnerability service does not respond here"
    return "\n".join([f"{name}: {audit.judged} packages audited", *audit.vulnerable])


TOOLS: dict[str, Callable[[], Audit]] = {
    "Python": lambda: python(pins(*(ROOT / lock for lock in LOCKS))),
    "npm": lambda: of_npm(_answer(["npm", "audit", "--json", "--fetch-retries=0"])),
}


def main(tools: Mapping[str, Callable[[], Audit]] = TOOLS) -> int:
    """Print the findings of the tools; return 1 if something is vulnerable."""
    with ThreadPoolExecutor() as pool:
        audits = dict(zip(tools, pool.map(lambda ask: ask(), tools.values()), strict=True))
    for name, audit in audits.items():
        print(report(name, audit))
    return 1 if any(audit.vulnerable for audit in audits.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
