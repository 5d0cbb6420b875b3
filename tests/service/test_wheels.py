"""Both wheels, built and installed in an environment that has nothing of this checkout, and used from there.

Third-party packages come from this environment's folder, so that no network is needed.
"""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from flit_core.wheel import make_wheel_in

from calibdb_client import Board
from tests.helpers import board_pictures
from tests.helpers.stack.processes import environment_of, run_installed

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "clients/python/examples"
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
    root = tmp_path_factory.mktemp("wheels")
    projects = (ROOT / "clients" / "python", ROOT / "layers" / "solver")
    wheels = [make_wheel_in(project / "pyproject.toml", root).file for project in projects]
    return environment_of(root, *wheels)


def test_installed_packages_need_no_opencv(environment: Path, tmp_path: Path) -> None:
    run_installed(environment / "python", "-c", WITHOUT_OPENCV, folder=tmp_path)


#: runs programs, each with its arguments, one after the other; prints a line after each
ONE_BY_ONE = """
import json, runpy, sys
for program, *arguments in json.loads(sys.argv[1]):
    sys.argv = [program, *arguments]
    try:
        runpy.run_path(program, run_name="__main__")
    except SystemExit as ended:
        assert not ended.code, ended.code
    print("-- ended")
"""


@pytest.fixture(scope="module")
def calibrated(environment: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("offline")
    board_pictures.write(folder / "photos", Board())
    command = ("calibrate", "photos", "--offline", "--json", "-o", "camera.json")
    known = ("--squares", "9x6", "--model", "rectilinear")  # to find both takes long
    output = run_installed(environment / "calibdb", *command, *known, folder=folder)
    assert abs(json.loads(output)["camera_matrix"][0][0] - board_pictures.MATRIX[0, 0]) < 5
    return folder


@pytest.fixture(scope="module")
def said(environment: Path, calibrated: Path) -> list[str]:
    """Output of the solver's README, of both example programs, and of the notebook, in that order."""
    tags = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    picture = np.full((480, 640), 255, dtype=np.uint8)
    picture[100:260, 200:360] = cv2.aruco.generateImageMarker(tags, 7, 160)
    cv2.imwrite(str(calibrated / "tag.png"), cv2.GaussianBlur(picture, (0, 0), 1))
    writer = cv2.VideoWriter(str(calibrated / "in.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10, (640, 480))
    for path in sorted((calibrated / "photos").iterdir()):
        writer.write(cv2.imread(str(path)))
    writer.release()
    quickstart = re.search(r"```python\n(.*?)```", (ROOT / "layers/solver/README.md").read_text(), re.DOTALL)
    assert quickstart
    code = quickstart[1] + "print(abs(calibration.camera.matrix[0, 0] - 560) < 5)\n"
    (calibrated / "readme.py").write_text(code)
    programs = (
        ("readme.py",),
        (str(EXAMPLES / "apriltag_pose.py"), "tag.png", "camera.json", "--side", "0.2"),
        (str(EXAMPLES / "undistorted_stream.py"), "in.avi", "camera.json", "out.avi"),
        (str(ROOT / "tests/helpers/notebook.py"), str(EXAMPLES / "calibration.ipynb")),
    )
    printed = run_installed(environment / "python", "-c", ONE_BY_ONE, json.dumps(programs), folder=calibrated)
    return printed.split("-- ended\n")


def test_code_of_the_readme_calibrates(said: list[str]) -> None:
    assert said[0].splitlines()[-1] == "True"


def test_example_finds_the_pose_of_a_tag(said: list[str]) -> None:
    (tag,) = [json.loads(line) for line in said[1].splitlines()]
    # 160 px of 0.2 m at a focal length of 560 px
    x, y, z = tag["tvec"]
    assert tag["id"] == 7
    assert abs(z - 0.7) < 0.02
    assert abs(x - (279.5 - 322) / 560 * 0.7) < 0.01
    assert abs(y - (179.5 - 237) / 558 * 0.7) < 0.01


def test_example_writes_a_rectified_video(calibrated: Path, said: list[str]) -> None:
    assert said[2].startswith("6 frames")
    there, frame = cv2.VideoCapture(str(calibrated / "out.avi")).read()
    assert there
    assert frame.shape == (480, 640, 3)


def test_notebook_runs_and_shows_two_plots(said: list[str]) -> None:
    assert "6 views" in said[3]
    sizes = json.loads(said[3].splitlines()[-1])
    assert len(sizes) == 2
    assert min(sizes) > 5000
