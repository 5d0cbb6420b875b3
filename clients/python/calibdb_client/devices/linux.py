"""Cameras of Linux: Video4Linux devices, named as Chromium names them.

Chromium takes the string of the USB interface (`device/interface` in sysfs), else the driver's card name,
which is cut at 31 bytes. It adds idVendor and idProduct of the interface's USB device. Source:
media/capture/video/linux/video_capture_device_factory_v4l2.cc of Chromium.
"""

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .system import Device, label_of

PLATFORM = "X11; Linux x86_64"
"""Chromium's platform on every Linux computer, whatever its processor: user agents are reduced."""
CAP_V4L2 = 200
MAX_NAME_BYTES = 256

_QUERYCAP = 0x80685600
_CAPABILITY = struct.Struct("=16s32s32sIII3I")
_CAPTURE, _OUTPUT, _DEVICE_CAPS = 0x1, 0x2, 0x80000000


@dataclass(frozen=True)
class Capability:
    """Answer to VIDIOC_QUERYCAP: the driver's name, and the bits of the physical device and of this node."""

    card: str
    capabilities: int
    device_caps: int

    @property
    def captures(self) -> bool:
        """True if the node delivers pictures; others carry metadata, or convert pictures in memory."""
        caps = self.device_caps if self.capabilities & _DEVICE_CAPS else self.capabilities
        return bool(caps & _CAPTURE) and not caps & _OUTPUT


def _query_capability(path: Path) -> Capability | None:
    """Ask a device for its capability; None if it cannot be opened."""
    import fcntl  # Unix only

    buffer = bytearray(_CAPABILITY.size)
    try:
        with path.open("rb", buffering=0) as device:
            fcntl.ioctl(device, _QUERYCAP, buffer)
    except OSError:
        return None
    _, card, _, _, capabilities, device_caps, *_ = _CAPABILITY.unpack(buffer)
    return Capability(card.split(b"\0")[0].decode(errors="replace"), capabilities, device_caps)


def devices(
    sys_class: Path = Path("/sys/class/video4linux"),
    query: Callable[[Path], Capability | None] = _query_capability,
) -> Sequence[Device]:
    """List the cameras in the order of their numbers; a device that cannot be opened is named by sysfs."""
    cameras = []
    for folder in sys_class.glob("video*"):
        number = re.fullmatch(r"video(\d{1,4})", folder.name)
        if not number:
            continue
        path = Path("/dev") / folder.name
        capability = query(path)
        if capability is not None and not capability.captures:
            continue
        if capability is None and _read(folder / "index") not in ("", "0"):
            continue  # further nodes of a camera carry metadata
        name = _read(folder / "device" / "interface") or (
            capability.card if capability else _read(folder / "name")
        )
        usb = (folder / "device").resolve().parent
        vendor, product = _read(usb / "idVendor")[:4], _read(usb / "idProduct")[:4]
        model = f"{vendor}:{product}" if vendor and product else ""
        label = label_of(name or folder.name, model)
        cameras.append(Device(int(number[1]), label, PLATFORM, str(path), CAP_V4L2))
    return sorted(cameras, key=lambda device: device.index)


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(MAX_NAME_BYTES).decode(errors="replace").strip()
    except OSError:
        return ""
