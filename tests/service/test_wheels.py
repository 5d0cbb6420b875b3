"""Both wheels, built and installed in an environment that has nothing of this checkout, and used from there.

Third-party packages come from this environment's folder, so that no network is needed.
"""

import json
import os
import re
import subprocess
import sysconfig
import venv
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from flit_core.wheel import make_wheel_in

import calibsolver
from calibdb_client import Board, Recording
from infra.server.server import Server
from tests.helpers import board_pictures
from tests.helpers.data import data_dir, external_data
from tests.helpers.service.client import Client, until
from tests.helpers.service.in_process import request
from tests.helpers.stack.processes import install_wheels, without_checkout

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
    """Folder of programs of an environment with the two wheels."""
    root = tmp_path_factory.mktemp("wheels")
    projects = (ROOT / "clients" / "python", ROOT / "layers" / "solver")
    wheels = [make_wheel_in(project / "pyproject.toml", root).file for project in projects]
    venv.create(root / "venv", with_pip=False)
    scripts = root / "venv" / "bin"
    install_wheels(scripts / "python", *wheels)
    (packages,) = (root / "venv" / "lib").glob("python*/site-packages")
    (packages / "third-party.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return scripts


def run(
    *command: str | Path, folder: Path, status: int = 0, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run a program with nothing of this checkout in its way."""
    named = without_checkout(os.environ) | variables
    done = subprocess.run(command, cwd=folder, env=named, capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    return done


def test_installed_packages_need_no_opencv(environment: Path, tmp_path: Path) -> None:
    run(environment / "python", "-c", WITHOUT_OPENCV, folder=tmp_path)


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
    """Folder with photographs of a board, and the calibration that the installed command made of them."""
    folder = tmp_path_factory.mktemp("offline")
    board_pictures.write(folder / "photos", Board())
    command = ("calibrate", "photos", "--offline", "--json", "-o", "camera.json")
    known = ("--squares", "9x6", "--model", "rectilinear")  # to find both takes long
    told = run(environment / "calibdb", *command, *known, folder=folder)
    assert abs(json.loads(told.stdout)["camera_matrix"][0][0] - board_pictures.MATRIX[0, 0]) < 5
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
    done = run(environment / "python", "-c", ONE_BY_ONE, json.dumps(programs), folder=calibrated)
    return done.stdout.split("-- ended\n")


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


@external_data
@pytest.mark.thorough
def test_installed_commands_calibrate_real_photographs_by_the_service(
    environment: Path, stack: Server, tmp_path: Path
) -> None:
    photographs = data_dir() / "photos" / "charuco_1280x720"
    camera = ("--label", "Microsoft LifeCam HD-3000 (045e:0779)")
    with stack.serve():
        service = {"CALIBDB_URL": stack.url, "CALIBDB_TOKEN": "cdb_dev_local"}
        asked = ("lookup", *camera, "--platform", "photographs", "--size", "1280x720", "--no-cache", "--json")
        calibdb = environment / "calibdb"
        unknown = run(calibdb, *asked, folder=tmp_path, status=1, **service)
        assert json.loads(unknown.stdout)["reason"] == "unknown_camera"
        agreed = (*camera, "--licence", "CC0-1.0")
        run(calibdb, "calibrate", str(photographs), *agreed, "-o", "camera.json", folder=tmp_path, **service)
        of = {"camera": camera[1], "platform": "photographs", "img_size": [1280, 720], "redirect": False}
        until(lambda: Client(stack).lookup(**of).json["reason"] == "too_few")  # the consensus comes after
        checked = run(calibdb, "check", str(photographs), *camera, "--json", folder=tmp_path, **service)
        assert json.loads(checked.stdout)["fits"] == "fits"
        known = json.loads((tmp_path / "camera.json").read_text())
        export = ("export", known["id"], "--format", "ros", "-o", "ros.yaml")
        run(calibdb, *export, folder=tmp_path, **service)
        path = f"/v1/calibrations/{known['id']}"
        stored = request(stack, "GET", path, {"authorization": "Bearer cdb_dev_local"})
    assert json.loads(stored.body)["licence"] == "CC0-1.0"
    recording = Recording.load(tmp_path / "camera.json")
    assert recording.board.squares == (8, 8)
    views = [recording.board.view(view.ids, view.points) for view in recording.views]
    # Least squares over the corners of the same board: bent and stretched as the fit says.
    shaped = calibsolver.fit(views, (1280, 720)).shaped(views)
    places = [view.object_points.astype(np.float32) for view in shaped]
    seen = [np.array(view.points, dtype=np.float32) for view in recording.views]
    guess = np.array([[1000.0, 0, 639.5], [0, 1000.0, 359.5], [0, 0, 1]])  # which boards that bend need
    _, matrix, _, _, _, std, *_ = cv2.calibrateCameraExtended(
        places, seen, (1280, 720), guess, None, flags=cv2.CALIB_USE_INTRINSIC_GUESS
    )
    assert len(recording.views) == 16
    fx, fy = known["camera_matrix"][0][0], known["camera_matrix"][1][1]
    assert abs(fx - matrix[0, 0]) < std.ravel()[0]
    assert abs(fy - matrix[1, 1]) < std.ravel()[1]
    # as ROS's camera_calibration_parsers reads it
    ros = yaml.safe_load((tmp_path / "ros.yaml").read_bytes())
    assert (ros["image_width"], ros["image_height"], ros["distortion_model"]) == (1280, 720, "plumb_bob")
    for name, rows, columns in (
        ("camera_matrix", 3, 3),
        ("distortion_coefficients", 1, 5),
        ("rectification_matrix", 3, 3),
        ("projection_matrix", 3, 4),
    ):
        assert (ros[name]["rows"], ros[name]["cols"], len(ros[name]["data"])) == (
            rows,
            columns,
            rows * columns,
        )
    assert ros["camera_matrix"]["data"][0] == pytest.approx(fx, abs=1e-6)
