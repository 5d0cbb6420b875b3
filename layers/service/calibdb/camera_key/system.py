"""Operating system, and device model, of a browser."""

import re
import unicodedata
from dataclasses import dataclass

from calibdb.camera_key.characters import visible
from calibdb.camera_key.owner import without_owner, without_telephone

# Parts that are kept; others are reduced to the family that they name, or left out.
_KNOWN = re.compile(
    r"x11|wayland|linux(?: (?:x86_64|i[3-6]86|amd64|aarch64|arm64|armv?[0-9a-z]{0,4}|riscv64|ppc64le))?"
    r"|u|k|wv|mobile|tablet|unknown|ubuntu|fedora|debian|rv:[0-9.]{1,12}"
    r"|win32|win64|x64|x86_64|wow64|arm64|arm|windows(?: nt)?(?: [0-9]{1,2}(?:\.[0-9]{1,5}){0,3})?"
    r"|macintosh|macintel|(?:(?:intel|ppc|arm) )?mac ?os(?: x)?(?: [0-9]{1,3}(?:[._][0-9]{1,4}){0,3})?"
    r"|(?:iphone|ipad|ipod)[0-9]{1,2},[0-9]{1,2}"
    r"|iphone|ipad|ipod(?: touch)?|ios(?: [0-9]{1,3}(?:[._][0-9]{1,4}){0,3})?"
    r"|cpu (?:iphone )?os [0-9]{1,3}(?:_[0-9]{1,4}){0,3} like mac os x"
    r"|cros \w{1,10} [0-9.]{1,20}|chrome ?os|chromium ?os|[a-z]{0,10}bsd(?: (?:amd64|i386|x86_64))?"
    r"|android(?: [0-9]{1,3}(?:\.[0-9]{1,3}){0,3})?|[a-z]{2}[-_][a-z]{2}|photographs|video|other",
    re.IGNORECASE,
)
# A device's model has a number or a known make, and is not the address of a site.
_DEVICE = re.compile(
    r"(?!.*[a-z]\.[a-z]{2})"
    r"(?=.*[0-9]|(?:google )?pixel\b|nexus\b|moto\b|redmi\b|poco\b|nokia\b)[^\W_][\w ()+./,&-]{0,47}?"
    r"(?: build/[\w.-]{1,40})?",
    re.IGNORECASE,
)
_USER_AGENT = re.compile(r"^Mozilla/[0-9.]+ \(([^)]*)\)")
# By what is shown. The first match counts: Android also calls itself Linux, and iOS "like Mac OS X".
_SYSTEMS = (
    ("iOS", re.compile(r"\b(?:(?:iphone|ipad|ipod)(?:[0-9]{1,2},[0-9]{1,2})?|ios)\b")),
    ("Android", re.compile(r"\bandroid\b")),
    ("ChromeOS", re.compile(r"\b(?:cros|chrome ?os|chromium ?os)\b")),
    ("Windows", re.compile(r"\bwindows\b")),
    ("macOS", re.compile(r"\b(?:macintosh|mac ?os|macos)\b")),
    ("Linux", re.compile(r"\b(?:linux|x11|[a-z]*bsd)\b")),
)
# Parts of Android's user agents that are not a device: reduced ones call every device "K".
_NO_DEVICE = re.compile(
    r"(?:linux|u|k|wv|mobile|tablet|unknown|rv:[0-9.]*|[a-z]{2}[-_][a-z]{2}|android(?: [0-9.]+)?)"
)
_BUILD = re.compile(r" build/.*$")
_MODEL_IPHONE = re.compile(r"\b(?:iphone|ipad|ipod)\b")
_IDENTIFIER = re.compile(r"\b(?:iphone|ipad|ipod)[0-9]{1,2},[0-9]{1,2}\b")


COMPUTERS = ("chromeos", "linux", "macos", "windows", "other")  # into which cameras are plugged
FILES = ("photographs", "video")


@dataclass(frozen=True)
class System:
    """A system by its family, and the device's model if the browser names it."""

    name: str  # one of the families above, of FILES, or "other"
    model: str = ""

    @property
    def text(self) -> str:
        """Distinguishing part, without the version."""
        return f"{self.name}; {self.model}" if self.model else self.name

    @property
    def is_file(self) -> bool:
        """True for photographs and videos, which a camera crops differently from its stream."""
        return self.name in FILES

    @property
    def is_one_device(self) -> bool:
        """True if all devices with this text have the same cameras."""
        return self.model != "" if self.name == "android" else _IDENTIFIER.fullmatch(self.model) is not None


def public_platform(platform: str) -> str:
    """Recognised parts of `platform` or a user agent: system, version, the device's model; else `other`."""
    text = visible(platform.replace('"', " "))
    match = _USER_AGENT.match(text)
    parts = [part.strip() for part in (match[1] if match else text).split(";")]
    android = any(_family(part) == "Android" for part in parts)
    public_parts: list[str] = []
    for part in parts:
        family = _family(part)
        if _KNOWN.fullmatch(part):
            public_parts.append(part)
        elif family:
            public_parts.append(family)
        elif android and _DEVICE.fullmatch(part) and without_owner(without_telephone(part)) == part:
            public_parts.append(part)
            android = False  # it has one model
    return "; ".join(dict.fromkeys(public_parts)) or "other"


def with_device(platform: str, device: str) -> str:
    """Platform with a device's model identifier, which Apple's browsers do not report."""
    match = _USER_AGENT.match(platform)
    said = match[1] if match else platform
    parts = [part.strip().casefold() for part in said.split(";")]
    return said if device.strip().casefold() in parts else f"{said}; {device.strip()}"


def system_of(platform: str) -> System:
    """System that `platform` names."""
    text = unicodedata.normalize("NFKC", public_platform(platform)).casefold()
    family = (_family(text) or "").lower()
    if family:
        return System(family, _model(family, text))
    return System(text if text in FILES else "other")


def _family(text: str) -> str | None:
    folded = text.casefold()
    return next((name for name, pattern in _SYSTEMS if pattern.search(folded)), None)


def _model(name: str, text: str) -> str:
    if name == "ios":
        match = _IDENTIFIER.search(text) or _MODEL_IPHONE.search(text)
        return match[0] if match else ""
    if name != "android":
        return ""
    parts = (_BUILD.sub("", part.strip()) for part in text.split(";"))
    return next((part for part in parts if part and not _NO_DEVICE.fullmatch(part)), "")
