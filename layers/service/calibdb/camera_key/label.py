"""Labels of cameras as browsers give them, and names that people give to modes."""

import re
import unicodedata
from dataclasses import dataclass

from calibdb.camera_key.apple import CAMERA_WORDS, in_english
from calibdb.camera_key.characters import in_latin, visible
from calibdb.camera_key.names import without_maker
from calibdb.camera_key.owner import without_owner, without_path, without_telephone
from calibdb.camera_key.virtual import program, spelling_of

# Chromium appends ` (vid:pid)`; on macOS it cuts it out of an id that need not be one (`(m-de:vice)`).
_ID = re.compile(r"\(\s*([^\s():]{4}):([^\s():]{4})\s*\)\s*$")
_HEX = re.compile(r"[0-9a-f]{4}")
_NO_VENDOR = frozenset({"0000", "ffff"})  # drivers without an id of their own report these
_MARKS = re.compile(r"[®™©]|\((?:r|tm|c)\)", re.IGNORECASE)
# Linux' driver says name and interface, cut to 31 bytes: `Integrated Camera: Integrated C`.
_REPEATED = re.compile(r"^(.+?): (.+)$")
# Android's older interface to the same two cameras; beyond these the numbers may mean others.
_ANDROID = re.compile(r"^camera2 (?=[01], facing )")

# Owners name Apple's phones in any grammar: of such labels only known words are kept.
_APPLE = re.compile(r"iphone|ipad|ipod|desk view|schreibtischansicht", re.IGNORECASE)
_APPLE_DEVICE = re.compile(r"iphone|ipad|ipod", re.IGNORECASE)
_MODEL = r"[1-9][0-9]?e?|xs|xr|x|se|pro|max|plus|mini|air"
_MODEL_WORD = re.compile(_MODEL, re.IGNORECASE)
_APPLE_WORDS = re.compile(
    r"(?:iphone|ipad|ipod)|[0-9]+(?:\.[0-9]+)?mm|f/[0-9]+(?:\.[0-9]+)?|"
    rf"(?<![a-z0-9])(?:apple|{_MODEL}|ultra|wide|dual|triple|"
    r"telephoto|truedepth|back|front|desk view)(?![a-z0-9])|schreibtischansicht|" + "|".join(CAMERA_WORDS),
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Label:
    """Parsed label: a normalised name and a USB id, or the program that poses as a camera."""

    name: str
    usb_id: str | None
    virtual: bool


def public_label(label: str) -> str:
    """Return `label` without the name of a person, as it may be stored and shown."""
    text = visible(label)
    # Until nothing is left to cut, so that the result is its own public label.
    while (shorter := _public(text)) != text:
        text = shorter
    return text


def _public(text: str) -> str:
    text = in_latin(text)
    usb_match = _ID.search(text)
    usb_id = f" {usb_match[0].strip()}" if usb_match else ""
    name = text[: usb_match.start()].strip() if usb_match else text
    # First: `iPhone +49 170 1234567` is not an iPhone 49.
    name = without_telephone(without_path(name))
    if (match := _REPEATED.match(name)) and match[1].startswith(match[2]):
        name = match[1]
    if posing := program(_plain(text)):
        return spelling_of(posing, name)
    if _APPLE.search(name):
        return " ".join(_apple_words(name)) + usb_id
    if in_english(name.casefold()):
        return f"{name}{usb_id}"
    return (without_owner(name) or "camera") + usb_id


def read(label: str, system: str) -> Label:
    """Parse `label` on a system of this family."""
    text = _plain(public_label(label))
    usb_id = None
    if match := _ID.search(text):
        text = text[: match.start()].strip()
        if _HEX.fullmatch(match[1]) and _HEX.fullmatch(match[2]) and match[1] not in _NO_VENDOR:
            usb_id = f"{match[1]}:{match[2]}"
    if posing := program(text):
        return Label(posing, None, virtual=True)
    if system in ("ios", "macos"):
        text = in_english(text) or text
    if _APPLE.search(text):
        text = _english_camera(text)
    return Label(without_maker(_ANDROID.sub("camera ", text)), usb_id, virtual=False)


def _apple_words(name: str) -> list[str]:
    """List the known words of an Apple device's name. A model's stand after it: Max before is a person."""
    device = _APPLE_DEVICE.search(name)
    words = []
    for match in _APPLE_WORDS.finditer(name):
        before = device is not None and match.start() < device.start()
        if not (before and _MODEL_WORD.fullmatch(match[0])):
            words.append(match[0])
    return words


def _plain(text: str) -> str:
    text = " ".join(unicodedata.normalize("NFKC", _MARKS.sub(" ", text)).casefold().split())
    return " ".join(_MARKS.sub(" ", text).split())


def _english_camera(text: str) -> str:
    """Name of an iPhone or iPad with "camera" last."""
    device = _APPLE_WORDS.findall(text)
    words = [word for word in device if word not in CAMERA_WORDS]
    words = ["desk view" if word == "schreibtischansicht" else word for word in words]
    return " ".join([*words, *(["camera"] if len(words) < len(device) else [])])


MAX_MODE_NAME = 32
# Letters and digits of any script, and the signs of settings: `4K, 16:9`, `78°`, `Linear + Horizon`.
_ALLOWED = re.compile(r"[^\W_](?:[\w °.,:+×%/-]*[\w°%+])?")
_LONG_NUMBER = re.compile(r"\d{5}")


def public_mode_name(text: str) -> str:
    """Public name of a camera's mode, such as `stabilisation on`; empty if it is refused."""
    name = unicodedata.normalize("NFC", visible(text))
    while (shorter := without_owner(without_telephone(without_path(name)))) != name:
        name = shorter
    allowed = len(name) <= MAX_MODE_NAME and _ALLOWED.fullmatch(name) and not _LONG_NUMBER.search(name)
    return name if allowed else ""
