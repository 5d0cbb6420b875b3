"""Fit of real photographs that tests of several modules begin with."""

import pytest

from calibdb_client import CaptureResult, Recording, offline, session
from tests.helpers.recordings import recording_of


@pytest.fixture(scope="session")
def left() -> CaptureResult:
    return offline.calibrate_recording(recording_of("opencv_left"), "rectilinear")


@pytest.fixture(scope="session")
def left_file(left: CaptureResult) -> bytes:
    """Content of the file that `calibdb submit` writes: the calibration with its corners."""
    return recording_of("opencv_left").content(left.calibration.record)


@pytest.fixture
def no_suggestion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calibrations with a given model do not look for a better one."""

    def given(_: Recording, model: str) -> tuple[str, None]:
        return model, None

    monkeypatch.setattr(session, "chosen_model", given)
