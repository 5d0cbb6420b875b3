"""The command `plot`: reports that load nothing from elsewhere."""

import re
from pathlib import Path

import pytest

from calibdb_client import Calibration, UsageError, offline
from calibdb_client.cli import main
from calibdb_client.report import write_report
from tests.helpers.recordings import recording_of


def test_report_of_a_file_has_plots_and_a_row_per_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    recording_of("opencv_left").save("left.json")
    assert main(["submit", "left.json", "--offline", "--model", "rectilinear"]) == 0
    assert main(["plot", "left.json"]) == 0
    page = Path("report.html").read_text()
    assert page.count("<tr><td>") == 9 + 13 + page[: page.index("<h2>")].count("<tr><td>")
    assert "12.jpg" in page
    assert len(page) > 100_000
    assert "<script" not in page
    assert set(re.findall(r'src="([^"]{0,22})', page)) == {"data:image/png;base64,"}
    for name, start in (("report.png", b"\x89PNG"), ("report.pdf", b"%PDF")):
        assert main(["plot", "left.json", "-o", name]) == 0
        assert Path(name).read_bytes().startswith(start)
    assert main(["plot", "left.json", "-o", "report.gif"]) == 2


def test_report_without_corners_is_refused(tmp_path: Path) -> None:
    calibration = offline.calibrate_recording(recording_of("opencv_left"), "rectilinear").calibration
    with pytest.raises(UsageError, match="corners"):
        write_report(tmp_path / "report.html", Calibration(calibration.record))
