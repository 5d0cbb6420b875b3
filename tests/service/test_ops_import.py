"""Calibrations made with other tools, taken in by the operator."""

from pathlib import Path

import numpy as np

from calibsolver import View, fit, formats
from infra.server.server import Server
from tests.helpers.data import corner_views, on_board
from tests.helpers.service.client import Client
from tests.helpers.service.commands import Operator
from tests.helpers.solver.export_sources import subject

WHOSE = ["--camera", "Microsoft LifeCam HD-3000 (045e:0779)", "--platform", "X11; Linux x86_64"]


SIZE = (640, 480)


def test_keypoints_become_a_calibration_like_any_other(operator: Operator, tmp_path: Path) -> None:
    """One row of corners has no pose; the other views make the calibration that they make alone."""
    views, size = corner_views("opencv_left")
    assert size == SIZE
    # the squares are 25.4 mm wide
    *views, last = [View(25.4 * view.object_points, view.image_points) for view in views[:8]]
    row = View(last.object_points[:6], last.image_points[:6])
    calibration = fit(on_board(views)[2], SIZE)  # in the frame and unit of the service's boards
    source = formats.ExportSource(calibration.camera, (*views, row), name="LifeCam", rms=0.2)
    content = formats.write(source, "photonvision").content
    path = tmp_path / "lifecam.json"
    path.write_bytes(content)
    printed = operator("import", path, *WHOSE, "--model", "rectilinear")
    assert operator("import", path, *WHOSE, "--model", "rectilinear") == printed, "it is one calibration"
    again = tmp_path / "again.json"  # another file of the same capture
    again.write_bytes(content.replace(b'"camera', b' "camera'))
    assert "known already" in operator("import", again, *WHOSE, "--model", "rectilinear", status=1)
    assert "7 views (1 set aside: degenerate)" in printed
    name = printed.removeprefix("calibration ").split(":")[0]
    with Server(operator.folder) as stack:
        client = Client(stack)
        shown = client.calibration(name).json
        assert np.allclose(shown["camera_matrix"], calibration.camera.matrix, rtol=1e-6)
        assert shown["report"]["verdict"]["level"] in ("good", "fair", "poor")
        assert [view["reason"] for view in shown["report"]["views"]] == [None] * 7 + ["degenerate"]
        # audited like any other: its keypoints make the fit of another model, too
        wide = client.calibration(name, "format=gyroflow")
        assert wide.status == 200
        asked = client.lookup(camera=WHOSE[1], platform=WHOSE[3], img_size=list(SIZE), redirect="false")
        assert (asked.status, asked.json["reason"]) == (404, "too_few")


def test_camera_without_keypoints_is_imported_as_a_seed(operator: Operator, tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    path.write_bytes(formats.write(subject("rectilinear"), "ros").content)
    assert "first guess" in operator("import", path, *WHOSE)
    with Server(operator.folder) as stack:
        assert Client(stack).lookup(camera=WHOSE[1], platform=WHOSE[3], redirect="false").status == 404


def test_table_of_corners_is_stored_with_the_board_and_size_given(operator: Operator, tmp_path: Path) -> None:
    path = tmp_path / "corners.vnl"
    table = formats.write(subject("rectilinear"), "corners-vnl").content
    path.write_bytes(table + b"empty.png - - -\n")
    board = ["--squares", "9x6", "--img-size", "1280x720", "--model", "rectilinear"]
    assert "10 views, rectilinear" in operator("import", path, *WHOSE, *board)


def test_malformed_file_stores_nothing(operator: Operator, tmp_path: Path) -> None:
    path = tmp_path / "broken.json"
    path.write_text("{")
    complaint = operator("import", path, *WHOSE, status=1)
    assert path.name in complaint
    assert "not JSON" in complaint
    few = formats.ExportSource(subject("rectilinear").camera, subject("rectilinear").views[:2])
    path.write_bytes(formats.write(few, "photonvision").content)
    assert "a calibration needs 4" in operator("import", path, *WHOSE, status=1)
    operator("import", path, "--camera", "OBS Virtual Camera", "--platform", "Windows", status=1)
    with Server(operator.folder) as stack:
        assert Client(stack).call("GET", "/v1/cameras").json["cameras"] == []
