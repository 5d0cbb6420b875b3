"""A label as a browser gives it, and what of it names the camera."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from calibdb.camera_key.apple import CAMERA_WORDS, in_english
from calibdb.camera_key.names import without_maker
from calibdb.camera_key.virtual import program

# Chromium appends ` (vid:pid)`; on macOS it cuts it out of an id that need not be one (`(m-de:vice)`).
_ID = re.compile(r"\(\s*([^\s():]{4}):([^\s():]{4})\s*\)\s*$")
_HEX = re.compile(r"[0-9a-f]{4}")
_NO_VENDOR = frozenset({"0000", "ffff"})  # drivers without an id of their own report these
_MARKS = re.compile(r"[®™©]|\((?:r|tm|c)\)", re.IGNORECASE)
# Linux' driver says name and interface, cut to 31 bytes: `Integrated Camera: Integrated C`.
_REPEATED = re.compile(r"^(.+?): (.+)$")
# Android's older interface to the same two cameras; beyond these the numbers may mean others.
_ANDROID = re.compile(r"^camera2 (?=[01], facing )")

# "Anna's iPhone Camera": whose it is, is nobody's business, and says nothing about the optics.
_OWNER = re.compile(
    r"^.{1,64}?['’]s? +(?=(?:galaxy|pixel|phone|camera|macbook|imac|webcam|tablet|redmi|xperia)\b)",
    re.IGNORECASE,
)
_OWNER_GENITIVE = re.compile(r"^\w{2,40}s +(?=(?:galaxy|pixel|redmi|xperia)\b)", re.IGNORECASE)
_OWNER_AFTER = re.compile(
    r"\b((?:galaxy|pixel|macbook|imac|redmi|xperia)\b[\w +-]*?) "
    r"+(?:von|de|di|da|do|van|av|af|fra|of|od|від|от) .*$",
    re.IGNORECASE,
)
_PHONE_LINK = re.compile(r"^.*\((windows virtual camera)\)", re.IGNORECASE)
# Apple's phones are called what their owners like, in any grammar: of such labels only known words are kept.
_APPLE = re.compile(r"iphone|ipad|ipod", re.IGNORECASE)
_APPLE_WORDS = re.compile(
    r"(?:iphone|ipad|ipod)|[0-9]+(?:\.[0-9]+)?mm|f/[0-9]+(?:\.[0-9]+)?|"
    r"(?<![a-z0-9])(?:apple|[1-9][0-9]?e?|xs|xr|x|se|pro|max|plus|mini|air|ultra|wide|dual|triple|"
    r"telephoto|truedepth|back|front|desk view)(?![a-z0-9])|schreibtischansicht|" + "|".join(CAMERA_WORDS),
    re.IGNORECASE,
)
_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn"})


@dataclass(frozen=True)
class Label:
    """What names the camera: a normalised name and a USB id; or the program that poses as one."""

    name: str
    usb_id: str | None
    virtual: bool


def public_label(label: str) -> str:
    """Return `label` without the name of a person, as it may be stored and shown."""
    text = label.strip()
    if match := _PHONE_LINK.search(text):
        return match[1]
    if _APPLE.search(text):
        return _apple_label(text)
    text = _OWNER_GENITIVE.sub("", _OWNER.sub("", text))
    return _OWNER_AFTER.sub(r"\1", text).strip() or "camera"


def read(label: str, system: str) -> Label:
    """Return what `label` says, on a system of this family."""
    visible = "".join(c if unicodedata.category(c) not in _INVISIBLE else " " for c in public_label(label))
    text = " ".join(unicodedata.normalize("NFKC", _MARKS.sub(" ", visible)).casefold().split())
    text = " ".join(_MARKS.sub(" ", text).split())
    usb_id = None
    if match := _ID.search(text):
        text = text[: match.start()].strip()
        if _HEX.fullmatch(match[1]) and _HEX.fullmatch(match[2]) and match[1] not in _NO_VENDOR:
            usb_id = f"{match[1]}:{match[2]}"
    if posing := program(text):
        return Label(posing, None, virtual=True)
    if (match := _REPEATED.match(text)) and (match[1].startswith(match[2]) or match[2].startswith(match[1])):
        text = match[1]
    if system in ("ios", "macos"):
        text = in_english(text) or text
    if _APPLE.search(text):
        text = _english_camera(text)
    return Label(without_maker(_ANDROID.sub("camera ", text)), usb_id, virtual=False)


def _apple_label(text: str) -> str:
    usb_id = _ID.search(text)
    kept = " ".join(_APPLE_WORDS.findall(text[: usb_id.start()] if usb_id else text))
    return f"{kept} {usb_id[0].strip()}" if usb_id else kept


def _english_camera(text: str) -> str:
    """Return the name of an iPhone or iPad with "camera" last, whatever the language put first."""
    device = _APPLE_WORDS.findall(text)
    words = [word for word in device if word not in CAMERA_WORDS]
    words = ["desk view" if word == "schreibtischansicht" else word for word in words]
    return " ".join([*words, *(["camera"] if len(words) < len(device) else [])])
