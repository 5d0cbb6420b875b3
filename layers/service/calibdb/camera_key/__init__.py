"""Camera keys: one name for one camera, whatever the browser calls it.

A browser reports a label (`Logitech HD Pro Webcam C920 (046d:082d)`) and a platform (`X11; Linux x86_64`).

* With a USB id in the label, id and name identify the camera, on any platform.
* Without one, name and system identify it; on Android also the device's model.
* A distinctive name (`HD Pro Webcam C920`) leads to the camera of the USB id known under it, on any computer.
* A generic name (`Integrated Camera`, `camera 0, facing back`) leads to no other camera. Without a device's
  model it is `ambiguous`: its calibrations may belong to different products.

The key begins with the version of these rules. `docs/camera-keys.md` measures them on real labels.
"""

import functools
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
    "current_key",
    "identify",
    "public_label",
    "public_platform",
]

VERSION = "c4"
PATTERN = re.compile(r"c[0-9]{1,3}-[a-z0-9-]{1,40}-[0-9a-f]{12}")
_SLUG_LENGTH = 32


@dataclass(frozen=True)
class Identity:
    """Identity of a camera, from label and platform."""

    key: str  # of USB id and name, or of name and system if there is no id
    name_key: str  # of name and system
    name_keys: frozenset[str]  # by which lookups find it: on every computer, if the name is distinct
    name: str  # normalised label
    usb_id: str | None  # `vid:pid`; None if the browser gave none, or one that no camera has
    virtual: bool  # a program that forwards another camera's image
    ambiguous: bool  # the key does not identify the product
    distinct: bool  # the name identifies the product


@functools.lru_cache(maxsize=256)
def identify(label: str, platform: str) -> Identity:
    """Identify the camera of `label` (`MediaStreamTrack.label`) and `platform`.

    `platform` is the parenthesised part of the user agent, a whole user agent, or client hints in the
    same form: `Linux; Android 14; Pixel 8`.
    """
    system = system_of(platform)
    parsed = read(label, system.name)
    says_enough = not says_too_little(parsed.name) or (system.is_file and names_its_model(parsed.name))
    distinct = says_enough and not parsed.virtual
    name_key = _key(parsed.name, "", "" if parsed.virtual else system.text, parsed.virtual)
    key = _key(parsed.name, parsed.usb_id, "", parsed.virtual) if parsed.usb_id else name_key
    # A webcam moves from computer to computer; what a phone or a laptop has built in does not.
    travels = distinct and not system.is_file
    everywhere = [_key(parsed.name, "", c, False) for c in COMPUTERS]
    return Identity(
        key=key,
        name_key=name_key,
        name_keys=frozenset(everywhere if travels else [name_key]),
        name=parsed.name,
        usb_id=parsed.usb_id,
        virtual=parsed.virtual,
        ambiguous=not (parsed.usb_id or distinct or system.is_one_device),
        distinct=distinct,
    )


def camera_key(label: str, platform: str) -> str:
    """Key of the camera that a browser reports, such as `c4-hd-pro-webcam-c920-0123456789ab`."""
    return identify(label, platform).key


def current_key(key: str, label: str, platform: str) -> str:
    """Return today's key of a camera that was stored under `key`."""
    return key if key.startswith(f"{VERSION}-") else camera_key(label, platform)


def _key(name: str, usb_id: str, place: str, virtual: bool) -> str:
    identity = [VERSION, name, usb_id, place, virtual]
    digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:12]
    ascii_name = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    slug = re.sub(r"[^a-z0-9]+", "-", ascii_name).strip("-")[:_SLUG_LENGTH].rstrip("-")
    return f"{VERSION}-{slug or 'camera'}-{digest}"
