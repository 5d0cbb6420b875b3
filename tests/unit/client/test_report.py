"""The command `plot`: reports that load nothing from elsewhere."""

import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from calibdb_client import Board, Calibration, CameraKey, Recording, UsageError
from calibdb_client.recording import RecordedView
from calibdb_client.report import write_report
from calibsolver import plots
from tests.helpers.command import calibdb
from tests.helpers.service.client import Truth
from tests.helpers.service.published import held
from tests.unit.client.test_calibration import RECORD


@pytest.mark.usefixtures("working")
def test_report_of_a_file_has_plots_and_a_row_per_picture(left_file: bytes) -> None:
    Path("left.json").write_bytes(left_file)
    assert calibdb("plot left.json") == 0
    page = Path("report.html").read_text()
    assert all(f"{n:02}.jpg" in page for n in range(13))
    assert len(page) > 100_000
    assert "<script" not in page
    assert set(re.findall(r'src="([^"]{0,22})', page)) == {"data:image/png;base64,"}


def test_report_without_corners_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="corners"):
        write_report(tmp_path / "report.html", Calibration(RECORD))


@pytest.mark.usefixtures("no_suggestion", "working")
def test_bent_board_is_named_by_the_command_and_the_report(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its middle rises by 0.08 squares, 0.7 % of its length off a plane."""
    in_mm = ["--square-mm", "30"]
    monkeypatch.setattr(plots, "report", lambda *_: Figure())
    views = tuple(
        RecordedView(f"{n}.jpg", tuple(ids), tuple((x, y) for x, y in points))
        for n, (ids, points) in enumerate(held(Truth(sag=0.08), 8))
    )
    Recording(CameraKey("Webcam", "linux", (1280, 720)), Board(), views).save("bent.json")
    assert calibdb("submit bent.json --offline --model rectilinear", *in_mm) == 0
    (millimetres,) = re.findall(r"Your board .*", capsys.readouterr().err)
    assert calibdb("plot bent.json", *in_mm) == 0
    assert re.findall(r"Your board [^<]*", Path("report.html").read_text()) == [millimetres]
    found = re.fullmatch(r"Your board is bent by (.*) mm; that was taken into account.", millimetres)
    assert found is not None
    assert float(found[1]) == pytest.approx(0.007 * 7 * 30, abs=0.3)  # seven squares between the corners
    assert calibdb("plot bent.json -o report.pdf") == 0
    assert Path("report.pdf").read_bytes().startswith(b"%PDF")
    assert calibdb("plot bent.json -o report.gif") == 2
