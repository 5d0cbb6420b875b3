"""Browsers of this machine."""

import shutil

import pytest


def executable(name: str) -> str:
    """Path of a browser; the test is skipped where it is not installed."""
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"{name} is not installed")
    return path
