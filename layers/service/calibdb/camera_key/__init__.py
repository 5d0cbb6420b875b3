"""Camera keys: one name for one camera, whatever the browser calls it.

A browser reports a label (`Logitech HD Pro Webcam C920 (046d:082d)`) and a platform (`X11; Linux x86_64`).
Where the label carries a USB id, that and the name are the camera, on any platform. Without one, name and
system are all there is, on Android the device's model, too. A name alone that says which product it is
(`HD Pro Webcam C920`) leads to the camera of the USB id that is known under it, on every computer; one that
many products bear (`Integrated Camera`, `camera 0, facing back`) leads nowhere, and without a device's model
it is `ambiguous`: nobody's calibration can be told to be for it.

The key carries the version of these rules, so that a later version never mixes with an earlier one.
`docs/camera-keys.md` has what they achieve on labels that browsers really report.
"""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
from dataclasses import dataclass

from calibdb.camera_key.label import public_label, read
from calibdb.camera_key.names import names_its_model, says_too_little
from calibdb.camera_key.system import COMPUTERS, public_platform, system_of

__all__ = [
    "PATTERN",
    "VERSION",
    "Identity",
    "camera_key",
    "current",
    "identify",
    "public_label",
    "public_platform",
]

VERSION = "c4"
PATTERN = re.compile(r"c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12}")
_SLUG_LENGTH = 32


@dataclass(frozen=True)
class Identity:
    """What label and platform say about a camera.

    Attributes
    ----------
    key
        Key of the camera: of USB id and name, or of the name alone where there is no id.
    name_key
        Key of name and system: under it the camera is asked for where a browser gives no id.
    name_keys
        All keys under which it is asked for by its name: on every computer, where the name is distinct.
    name
        Normalised label.
    usb_id
        `vid:pid`, None where the browser gave none or one that no camera has.
    virtual
        A program that hands on another camera's picture: no optics of its own.
    ambiguous
        The key does not say which product this is.
    distinct
        The name by itself says which product this is.

    """

    key: str
    name_key: str
    name_keys: frozenset[str]
    name: str
    usb_id: str | None
    virtual: bool
    ambiguous: bool
    distinct: bool


def identify(label: str, platform: str) -> Identity:
    """Return what `label` (`MediaStreamTrack.label`) and `platform` say about the camera.

    `platform` is the parenthesised part of the user agent, a whole user agent, or the same made of client
    hints: `Linux; Android 14; Pixel 8`.
    """
    system = system_of(platform)
    found = read(label, system.name)
    says_enough = not says_too_little(found.name) or (system.is_file and names_its_model(found.name))
    distinct = says_enough and not found.virtual
    name_key = _key(found.name, "", "" if found.virtual else system.text, found.virtual)
    key = _key(found.name, found.usb_id, "", found.virtual) if found.usb_id else name_key
    # A webcam moves from computer to computer; what a phone or a laptop has built in does not.
    travels = distinct and not system.is_file
    return Identity(
        key=key,
        name_key=name_key,
        name_keys=frozenset(_key(found.name, "", c, False) for c in COMPUTERS)
        if travels
        else frozenset({name_key}),
        name=found.name,
        usb_id=found.usb_id,
        virtual=found.virtual,
        ambiguous=not (found.usb_id or distinct or system.is_one_device),
        distinct=distinct,
    )


def camera_key(label: str, platform: str) -> str:
    """Return the key of the camera that a browser reports, such as `c4-hd-pro-webcam-c920-0123456789ab`.

    Version, a readable part, and 12 hex digits of the SHA-256 of everything that counts. Safe in URLs and
    object names.
    """
    return identify(label, platform).key


def current(key: str, label: str, platform: str) -> str:
    """Return today's key of a camera that was stored under `key`, perhaps by earlier rules."""
    return key if key.startswith(f"{VERSION}-") else camera_key(label, platform)


def _key(name: str, usb_id: str, place: str, virtual: bool) -> str:
    identity = [VERSION, name, usb_id, place, virtual]
    digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:12]
    ascii_name = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    slug = re.sub(r"[^a-z0-9]+", "-", ascii_name).strip("-")[:_SLUG_LENGTH].rstrip("-")
    return f"{VERSION}-{slug or 'camera'}-{digest}"
