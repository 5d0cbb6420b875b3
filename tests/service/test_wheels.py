"""Both wheels, built and installed in an environment that has nothing of this checkout, and used from there.

Third-party packages come from this environment's folder, so that no network is needed.
"""

import json
import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest
from flit_core.wheel import make_wheel_in

from calibdb_client import Board
from tests.helpers import board_pictures

ROOT = Path(__file__).parents[2]
WITHOUT_OPENCV = """
import sys
sys.modules["cv2"] = None
import calibsolver
from calibsolver import Board, Camera, View, capture, consensus, fit, formats, guidance, models, quality
from calibsolver.quality import assessment, model_selection
for name in guidance.GUIDES:
    guided = capture.Capture(Board(), (640, 480), guidance=name)
    assert len(guided.next_target([], guided.estimate([])).ids) == 40
import calibdb_client
assert "site-packages" in calibsolver.__file__ and "site-packages" in calibdb_client.__file__
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of programs of an environment with the two wheels."""
    root = tmp_path_factory.mktemp("wheels")
    projects = (ROOT / "clients" / "python", ROOT / "layers" / "solver")
    wheels = [make_wheel_in(project / "pyproject.toml", root).file for project in projects]
    venv.create(root / "venv", with_pip=False)
    scripts = root / "venv" / "bin"
    install = ("install", "--quiet", "--no-index", "--no-deps", "--no-compile", *map(str, wheels))
    subprocess.run([sys.executable, "-m", "pip", "--python", str(scripts / "python"), *install], check=True)
    (packages,) = (root / "venv" / "lib").glob("python*/site-packages")
    (packages / "third-party.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return scripts


def run(*command: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a program with nothing of this checkout in its way."""
    names = {name: value for name, value in os.environ.items() if not name.startswith(("CALIBDB", "PYTHON"))}
    return subprocess.run(command, cwd=folder, env=names, check=True, capture_output=True, text=True)


def test_installed_packages_need_no_opencv(environment: Path, tmp_path: Path) -> None:
    run(environment / "python", "-c", WITHOUT_OPENCV, folder=tmp_path)


def test_installed_command_calibrates_a_folder_offline(environment: Path, tmp_path: Path) -> None:
    board_pictures.write(tmp_path / "photos", Board())
    told = run(environment / "calibdb", "calibrate", "photos", "--offline", "--json", folder=tmp_path)
    matrix = json.loads(told.stdout)["camera_matrix"]
    assert abs(matrix[0][0] - board_pictures.MATRIX[0, 0]) < 5
    quickstart = re.search(r"```python\n(.*?)```", (ROOT / "layers/solver/README.md").read_text(), re.DOTALL)
    assert quickstart
    code = quickstart[1] + "print(abs(calibration.camera.matrix[0, 0] - 560) < 5)\n"
    assert run(environment / "python", "-c", code, folder=tmp_path).stdout.splitlines()[-1] == "True"
