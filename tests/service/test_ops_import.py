"""Calibrations made with other tools, taken in by the operator."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from calibsolver import Calibration, View, fit, formats
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.data import corner_views, on_board
from tests.helpers.service.client import TOKEN, Client
from tests.helpers.solver.export_sources import subject

WHOSE = ["--camera", "Microsoft LifeCam HD-3000 (045e:0779)", "--platform", "X11; Linux x86_64"]


@pytest.fixture
def data_dir(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    return tmp_path / "data"


SIZE = (640, 480)


def real_views() -> tuple[View, ...]:
    """Views of a board whose squares are 25.4 mm wide."""
    views, size = corner_views("opencv_left")
    assert size == SIZE
    return tuple(View(25.4 * view.object_points, view.image_points) for view in views[:8])


def fitted_as_imported(views: Sequence[View]) -> Calibration:
    """Fit views in the frame and unit of the service's boards, in the board's shape."""
    return fit(on_board(views)[2], SIZE)


def test_keypoints_become_a_calibration_like_any_other(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    views = real_views()
    calibration = fitted_as_imported(views)
    file = formats.write(
        formats.ExportSource(
            calibration.camera, views, name="LifeCam", rms=calibration.avg_reprojection_error
        ),
        "photonvision",
    )
    path = tmp_path / "lifecam.json"
    path.write_bytes(file.content)
    for _ in range(2):  # the same file twice is one calibration
        assert main(["import", str(path), *WHOSE, "--model", "rectilinear"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == said[1]
    again = tmp_path / "again.json"  # another file of the same capture
    again.write_bytes(file.content.replace(b'"camera', b' "camera'))
    assert main(["import", str(again), *WHOSE, "--model", "rectilinear"]) == 1
    assert "known already" in capsys.readouterr().err
    name = said[0].removeprefix("calibration ").split(":")[0]
    with Server(data_dir) as stack:
        client = Client(stack)
        shown = client.call("GET", f"/v1/calibrations/{name}", token=TOKEN).json
        assert np.allclose(shown["camera_matrix"], calibration.camera.matrix, rtol=1e-6)
        assert shown["report"]["verdict"]["level"] in ("good", "fair", "poor")
        assert len(shown["report"]["views"]) == len(views)
        # audited like any other: its keypoints make the fit of another model, too
        wide = client.call("GET", f"/v1/calibrations/{name}", token=TOKEN, query="format=gyroflow")
        assert wide.status == 200
        asked = client.lookup(camera=WHOSE[1], platform=WHOSE[3], img_size=list(SIZE), redirect="false")
        assert asked.status == 404
        assert asked.json["reason"] == "too_few"


def test_import_sets_a_degenerate_view_aside(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One row of corners has no pose; the seven other views make the calibration that they make alone."""
    views = real_views()
    row = View(views[7].object_points[:6], views[7].image_points[:6])
    calibration = fitted_as_imported(views[:7])
    content = formats.write(
        formats.ExportSource(calibration.camera, (*views[:7], row), name="LifeCam", rms=0.2), "photonvision"
    ).content
    path = tmp_path / "lifecam.json"
    path.write_bytes(content)
    assert main(["import", str(path), *WHOSE, "--model", "rectilinear"]) == 0
    said = capsys.readouterr().out
    assert "7 views (1 set aside: degenerate)" in said
    with Server(data_dir) as stack:
        name = said.removeprefix("calibration ").split(":")[0]
        shown = Client(stack).call("GET", f"/v1/calibrations/{name}", token=TOKEN).json
    assert np.allclose(shown["camera_matrix"], calibration.camera.matrix, rtol=1e-6)
    assert [view["reason"] for view in shown["report"]["views"]] == [None] * 7 + ["degenerate"]


def test_camera_without_keypoints_is_imported_as_a_seed(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "camera.yaml"
    path.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    assert main(["import", str(path), *WHOSE]) == 0
    assert "first guess" in capsys.readouterr().out
    with Server(data_dir) as stack:
        asked = Client(stack).lookup(camera=WHOSE[1], platform=WHOSE[3], redirect="false")
        assert asked.status == 404
        assert asked.json["reason"] in ("unknown_camera", "too_few")


@pytest.mark.usefixtures("data_dir")
def test_table_of_corners_is_stored_with_the_board_and_size_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "corners.vnl"
    table = formats.write(subject("rectilinear"), "corners-vnl").content
    path.write_bytes(table + b"empty.png - - -\n")
    board = ["--squares", "9x6", "--img-size", "1280x720", "--model", "rectilinear"]
    assert main(["import", str(path), *WHOSE, *board]) == 0
    assert "10 views, rectilinear" in capsys.readouterr().out


def test_malformed_file_stores_nothing(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.json"
    for content, reason in (
        ('{"cameraIntrinsics": {"data": [1, 2]}}', "resolution"),
        ("{", "not JSON"),
    ):
        path.write_text(content)
        assert main(["import", str(path), *WHOSE]) == 1
        said = capsys.readouterr().err
        assert path.name in said
        assert reason in said
    few = formats.ExportSource(subject("rectilinear").camera, subject("rectilinear").views[:2])
    path.write_bytes(formats.write(few, "photonvision").content)
    assert main(["import", str(path), *WHOSE]) == 1
    assert "a calibration needs 4" in capsys.readouterr().err
    assert main(["import", str(path), "--camera", "OBS Virtual Camera", "--platform", "Windows"]) == 1
    with Server(data_dir) as stack:
        assert Client(stack).call("GET", "/v1/cameras", token=TOKEN).json["cameras"] == []
