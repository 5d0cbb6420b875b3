"""Which system, and where it says so which device, a browser runs on."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

_USER_AGENT = re.compile(r"^Mozilla/[0-9.]+ \(([^)]*)\)")
_SYSTEMS = (
    # The first that is found: Android calls itself Linux, too, and iOS "like Mac OS X".
    ("ios", re.compile(r"\b(?:iphone|ipad|ipod|ios)\b")),
    ("android", re.compile(r"\bandroid\b")),
    ("chromeos", re.compile(r"\b(?:cros|chrome ?os|chromium ?os)\b")),
    ("windows", re.compile(r"\bwindows\b")),
    ("macos", re.compile(r"\b(?:macintosh|mac ?os|macos)\b")),
    ("linux", re.compile(r"\b(?:linux|x11|[a-z]*bsd)\b")),
)
# Parts of Android's user agents that are no device: reduced ones call every device "K".
_NO_DEVICE = re.compile(
    r"(?:linux|u|k|wv|mobile|tablet|unknown|rv:[0-9.]*|[a-z]{2}[-_][a-z]{2}|android(?: [0-9.]+)?)"
)
_BUILD = re.compile(r" build/.*$")
_MODEL_IPHONE = re.compile(r"\b(?:iphone|ipad|ipod)\b")


COMPUTERS = ("chromeos", "linux", "macos", "windows", "other")  # into which cameras are plugged
FILES = ("photographs", "video")


@dataclass(frozen=True)
class System:
    """A system by its family, and the device's model where the browser names it."""

    name: str  # one of the families above, of FILES, or "other"
    model: str = ""

    @property
    def text(self) -> str:
        """What distinguishes it; an update of the system does not change the camera."""
        return f"{self.name}; {self.model}" if self.model else self.name

    @property
    def is_file(self) -> bool:
        """Tell whether it is photographs or a video: the camera's name is from the file, written by itself.

        A camera cuts them differently, and its stream again.
        """
        return self.name in FILES

    @property
    def is_one_device(self) -> bool:
        """Tell whether all devices that say this have the same cameras. Apple's never say which they are."""
        return self.name == "android" and self.model != ""


def public_platform(platform: str) -> str:
    """Return the part of `platform` that is stored: of a whole user agent only its parenthesised part."""
    match = _USER_AGENT.match(platform.strip())
    return (match[1] if match else platform).strip()


def system_of(platform: str) -> System:
    """Return the system that `platform` names."""
    text = unicodedata.normalize("NFKC", public_platform(platform)).casefold()
    text = " ".join(text.replace('"', " ").split())
    for name, pattern in _SYSTEMS:
        if pattern.search(text):
            return System(name, _model(name, text))
    return System(text if text in FILES else "other")


def _model(name: str, text: str) -> str:
    if name == "ios":
        match = _MODEL_IPHONE.search(text)
        return match[0] if match else ""
    if name != "android":
        return ""
    parts = (_BUILD.sub("", part.strip()) for part in text.split(";"))
    return next((part for part in parts if part and not _NO_DEVICE.fullmatch(part)), "")
