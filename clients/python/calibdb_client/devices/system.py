"""Cameras of this system."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from ..errors import CameraError

_MODULES = {"linux": "linux", "darwin": "macos", "win32": "windows"}


@dataclass(frozen=True)
class Device:
    """A camera that is connected, under the label and platform that Chromium gives it.

    OpenCV opens it by `index` at the interface `backend`, 0: any. `path` is its path or unique id in the
    system.
    """

    index: int
    label: str
    platform: str
    path: str = ""
    backend: int = 0


def label_of(name: str, model_id: str) -> str:
    """Return the label of a name and a USB id `vid:pid` or "", as Chromium joins them."""
    name = name.strip()
    suffix = f" ({model_id})" if model_id else ""
    return name if name.endswith(suffix) else name + suffix


def _module(system: str) -> Any:
    return import_module(f".{_MODULES[system]}", __package__)


def devices() -> Sequence[Device]:
    """List the cameras of this machine. Raises CameraError on a system that is not known."""
    if sys.platform not in _MODULES:
        raise CameraError(f"cameras of {sys.platform} are not known: give label and platform")
    cameras: Sequence[Device] = _module(sys.platform).devices()
    return cameras


def platform_of(system: str = sys.platform) -> str:
    """Return the platform that Chromium gives on a system; Linux's for one that is not known."""
    return str(_module(system if system in _MODULES else "linux").PLATFORM)


def find(wanted: str | int, among: Sequence[Device] | None = None) -> Device:
    """Return the camera of an index, a path, or a part of its label. Raises CameraError.

    None or several may match.
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
