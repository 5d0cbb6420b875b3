"""Where the real data of the tests are."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]


def data_dir() -> Path:
    """Folder of CALIBDB_DATA. Absent: the test is skipped, but where `CI` is set it fails."""
    path = Path(os.environ.get("CALIBDB_DATA") or ROOT.parent / "shared" / "data")
    if path.is_dir():
        return path
    if os.environ.get("CI"):
        pytest.fail(f"no data at {path}: set CALIBDB_DATA")
    pytest.skip(f"no data at {path}: set CALIBDB_DATA")


def corner_set(name: str) -> dict[str, Any]:
    """One of `corners/*.json` as it is."""
    loaded: dict[str, Any] = json.loads((data_dir() / "corners" / f"{name}.json").read_text())
    return loaded
