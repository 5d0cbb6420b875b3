"""Tests of calibsolver and the client with the lowest and the highest versions: `python -m infra.ci.pins`.

uv, which `UV` names, installs the packages from this checkout, once with the oldest Python and the lowest
versions that their `pyproject.toml` permits, once with the newest of both.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PINS = {"lowest": ("3.10", "lowest-direct"), "highest": ("3.13", "highest")}
PACKAGES = ("./layers/solver[opencv]", "./clients/python[opencv]")
TOOLS = ("pytest", "pytest-xdist", "hypothesis", "pyyaml")
SELECTED = "not thorough and not external_data"
TESTS = (
    "tests/unit/solver/fitting/test_fit.py",
    "tests/unit/solver/fitting/test_rivals.py",
    "tests/unit/solver/formats/test_foreign_models.py",
    "tests/unit/solver/formats/test_conversion_error.py",
    "tests/unit/solver/formats/test_ray_fit.py",
    "tests/unit/solver/test_locate.py",
    "tests/unit/solver/rig/test_fit.py",
    "tests/unit/client/test_boards_in_pictures.py",
    "tests/unit/client/test_circles.py",
    "tests/unit/client/test_files.py",
    "tests/unit/client/test_fix.py",
    "tests/unit/client/test_undistort_and_check.py",
)


def main() -> int:
    """Run the tests with both; return the first status that is not 0."""
    uv = os.environ.get("UV") or shutil.which("uv")
    if uv is None:
        sys.exit("uv is missing: `make verify ONLY=pins` installs it")
    for name, (python, resolution) in PINS.items():
        folder = ROOT / ".build" / "pins" / name
        interpreter = str(folder / "bin" / "python")
        install = [uv, "pip", "install", "--quiet", "--python", interpreter]
        for command in (
            [uv, "venv", "--quiet", "--clear", "--python", python, str(folder)],
            [*install, "--resolution", resolution, *PACKAGES],
            [*install, *TOOLS],
        ):
            subprocess.run(command, cwd=ROOT, check=True)
        versions = "import sys, numpy, cv2; print(sys.version.split()[0], numpy.__version__, cv2.__version__)"
        print(f"{name}: Python, numpy, OpenCV", end=" ", flush=True)
        subprocess.run([interpreter, "-c", versions], check=True)
        tests = [interpreter, "-m", "pytest", "-q", "--confcutdir=tests/unit", "-m", SELECTED, *TESTS]
        elsewhere = {**os.environ, "PYTHONPATH": str(ROOT)}
        if status := subprocess.run(tests, cwd=ROOT, env=elsewhere, check=False).returncode:
            return status
    return 0


if __name__ == "__main__":
    sys.exit(main())
