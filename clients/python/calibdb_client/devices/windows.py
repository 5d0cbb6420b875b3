r"""Cameras of Windows, as Media Foundation lists them, named as Chromium names them.

Chromium takes the friendly name and the ids in the device's path (`\\?\usb#vid_046d&pid_082d&mi_00#…`). The
package cv2-enumerate-cameras counts the cameras as OpenCV does.
Source: media/capture/video/win/video_capture_device_factory_win.cc of Chromium.
"""

import re
from collections.abc import Iterable, Sequence

from ..errors import MissingPackageError
from .system import Device, label_of

PLATFORM = "Windows NT 10.0; Win64; x64"
"""Chromium's platform on every Windows: user agents are reduced."""
CAP_MSMF = 1400

_IDS = re.compile(r"vid_(.{4}).*?pid_(.{4})", re.IGNORECASE | re.DOTALL)


def devices() -> Sequence[Device]:
    """List the cameras. Raises MissingPackageError if the package that lists them is not installed."""
    try:
        from cv2_enumerate_cameras import enumerate_cameras
    except ImportError:
        raise MissingPackageError(
            "cameras of Windows are listed by a package: pip install cv2-enumerate-cameras"
        ) from None
    return name_devices((each.index, each.name, each.path or "") for each in enumerate_cameras(CAP_MSMF))


def name_devices(listed: Iterable[tuple[int, str, str]]) -> Sequence[Device]:
    """Return the cameras of which index, friendly name and path are known."""
    cameras = []
    for index, name, path in listed:
        ids = _IDS.search(path)
        label = label_of(name, f"{ids[1]}:{ids[2]}" if ids else "")
        cameras.append(Device(index, label, PLATFORM, path, CAP_MSMF))
    return cameras
