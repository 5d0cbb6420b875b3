"""List of this system's cameras, and one of them by index, path or name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from ..errors import CameraError
from . import linux, macos, windows
from .device import Device

_LISTS: dict[str, Callable[[], Sequence[Device]]] = {
    "linux": linux.devices,
    "darwin": macos.devices,
    "win32": windows.devices,
}
_PLATFORMS = {
    "linux": linux.LINUX_PLATFORM,
    "darwin": macos.MACOS_PLATFORM,
    "win32": windows.WINDOWS_PLATFORM,
}


def devices() -> Sequence[Device]:
    """List the cameras of this machine. Raises CameraError on a system that is not known."""
    listed = _LISTS.get(sys.platform)
    if listed is None:
        raise CameraError(f"cameras of {sys.platform} are not known: give label and platform")
    return listed()


def platform_of(system: str = sys.platform) -> str:
    """Return the platform that Chromium gives on a system; Linux's for one that is not known."""
    return _PLATFORMS.get(system, linux.LINUX_PLATFORM)


def find(wanted: str | int, among: Sequence[Device] | None = None) -> Device:
    """Return the camera of an index, a path, or a part of its label.

    Raises CameraError if there is none, or if several are called so; the text lists those that are there.
    """
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
