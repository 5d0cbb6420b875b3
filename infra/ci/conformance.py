"""Storage tests against an independent implementation of AWS: `python -m infra.ci.conformance`.

It finds differences that the lenience of the tests' emulator hides.
"""

import os
import subprocess
import sys
from pathlib import Path

from infra.ci import ministack

ROOT = Path(__file__).resolve().parents[2]
_TESTS = (
    "tests/unit/store/test_ports.py",
    "tests/unit/store/test_aws.py",
    "tests/unit/store/test_store.py",
    "tests/unit/store/test_calibrations.py",
    "tests/unit/store/test_names.py",
)


def main() -> int:
    """Run the tests against the server; return pytest's status."""
    with ministack.serving() as url:
        tests = [sys.executable, "-m", "pytest", "-q", *_TESTS]
        elsewhere = {**os.environ, "CONFORMANCE_ENDPOINT": url}
        return subprocess.run(tests, cwd=ROOT, env=elsewhere, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
