"""Cameras of this system."""

import sys
from collections.abc import Sequence

from ..errors import CameraError
from . import linux, macos, windows
from .device import Device

_SYSTEMS = {"linux": linux, "darwin": macos, "win32": windows}


def devices() -> Sequence[Device]:
    """List the cameras of this machine. Raises CameraError on a system that is not known."""
    system = _SYSTEMS.get(sys.platform)
    if system is None:
        raise CameraError(f"cameras of {sys.platform} are not known: give label and platform")
    cameras: Sequence[Device] = system.devices()
    return cameras


def platform_of(system: str = sys.platform) -> str:
    """Return the platform that Chromium gives on a system; Linux's for one that is not known."""
    return str(_SYSTEMS.get(system, linux).PLATFORM)


def find(wanted: str | int, among: Sequence[Device] | None = None) -> Device:
    """Return the camera of an index, a path, or a part of its label. Raises CameraError if not one."""
    cameras = devices() if among is None else among
    text = str(wanted)
    if text.isdigit():
        matching = [each for each in cameras if each.index == int(text)]
    else:
        matching = [each for each in cameras if text == each.path]
        matching = matching or [each for each in cameras if text.casefold() == each.label.casefold()]
        matching = matching or [each for each in cameras if text.casefold() in each.label.casefold()]
    if len(matching) == 1:
        return matching[0]
    listed = "; ".join(f"{each.index}: {each.label}" for each in matching or cameras) or "none"
    if matching:
        raise CameraError(f"several cameras are called {text!r}, choose one by its index: {listed}")
    raise CameraError(f"there is no camera {text!r}; cameras here: {listed}")
