"""Camera keys: one name for one camera, whatever the browser calls it.

First version of the normalisation. A browser reports a label (`Logitech HD Pro Webcam C920 (046d:082d)`) and
a platform (`X11; Linux x86_64`). Where the label carries a USB id, that and the name are the camera, on any
platform; without one, platform and name together are all there is. The key carries the version of these
rules, so that a later version never mixes with an earlier one.
"""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata

VERSION = "c1"
PATTERN = re.compile(r"c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12}")

_USB_ID = re.compile(r"\(\s*([0-9a-f]{4}):([0-9a-f]{4})\s*\)\s*$")
# Drivers without an id of their own report these; they are no camera's.
_BOGUS_IDS = frozenset({"0000:0000", "0000:0001", "ffff:ffff"})
_MARKS = re.compile(r"[®™©]|\((?:r|tm|c)\)")
# "Anna's iPhone Camera": whose it is, is nobody's business, and says nothing about the optics.
_OWNER = re.compile(
    r"^.{1,64}?['’]s? +(?=(?:iphone|ipad|ipod|galaxy|pixel|phone|camera|macbook|webcam)\b)", re.IGNORECASE
)
_VENDORS = re.compile(
    r"^(?:logitech|logi|microsoft|creative|razer|lenovo|hewlett[- ]packard|hp|dell|sony|asus|acer)\b[ ,.:-]*"
)
_USER_AGENT = re.compile(r"^Mozilla/[0-9.]+ \(([^)]*)\)")
# An update of the system does not change the camera.
_SYSTEM_VERSION = re.compile(
    r"(?<![a-z0-9])v?[0-9]+(?:[._][0-9]+)+(?![a-z0-9])|(?<=android )[0-9]+\b|\brv:[0-9.]+"
)
_SLUG_LENGTH = 32


def public_label(label: str) -> str:
    """Return `label` without the name of a person, as it may be stored and shown."""
    return _OWNER.sub("", label.strip()) or "camera"


def public_platform(platform: str) -> str:
    """Return the part of `platform` that is stored: of a whole user agent only its parenthesised part."""
    match = _USER_AGENT.match(platform.strip())
    return (match[1] if match else platform).strip()


def camera_key(label: str, platform: str) -> str:
    """Return the key of the camera that a browser reports, such as `c1-hd-pro-webcam-c920-0123456789ab`.

    Parameters
    ----------
    label
        `MediaStreamTrack.label`.
    platform
        The parenthesised part of the user agent; a whole user agent is reduced to it.

    Returns
    -------
    str
        Version, a readable part, and 12 hex digits of the SHA-256 of everything that counts. Safe in URLs and
        object names.

    """
    name, usb_id = _name(label)
    identity = [VERSION, name, usb_id or "", "" if usb_id else _platform(platform)]
    digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:12]
    ascii_name = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    slug = re.sub(r"[^a-z0-9]+", "-", ascii_name).strip("-")[:_SLUG_LENGTH].rstrip("-")
    return f"{VERSION}-{slug or 'camera'}-{digest}"


def _name(label: str) -> tuple[str, str | None]:
    text = unicodedata.normalize("NFKC", _MARKS.sub(" ", public_label(label))).casefold()
    usb_id = None
    if match := _USB_ID.search(text):
        text = text[: match.start()]
        usb_id = f"{match[1]}:{match[2]}"
        if usb_id in _BOGUS_IDS:
            usb_id = None
    text = " ".join(_MARKS.sub(" ", text).split())
    return _VENDORS.sub("", text) or text, usb_id


def _platform(platform: str) -> str:
    text = unicodedata.normalize("NFKC", public_platform(platform)).casefold()
    return "; ".join(
        " ".join(part.split()) for part in _SYSTEM_VERSION.sub("", text).split(";") if part.strip()
    )
