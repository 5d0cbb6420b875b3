"""Fit of real photographs that tests of several modules begin with."""

from pathlib import Path

import pytest

from calibdb_client import CaptureResult, offline
from tests.helpers.recordings import calibration_of, recording_of, without_suggestion


@pytest.fixture(scope="session")
def left() -> CaptureResult:
    return calibration_of("opencv_left")


@pytest.fixture(scope="session")
def left_file(left: CaptureResult) -> bytes:
    """Content of the file that `calibdb submit` writes: the calibration with its corners."""
    return recording_of("opencv_left").content(left.calibration.record)


@pytest.fixture
def working(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, and no service."""
    for name in ("CALIBDB_URL", "CALIBDB_TOKEN"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def no_suggestion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calibrations with a given model do not look for a better one."""
    monkeypatch.setattr(offline, "chosen_model", without_suggestion)
