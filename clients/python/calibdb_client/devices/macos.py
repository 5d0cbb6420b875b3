"""Cameras of macOS, as `system_profiler` lists them, named as Chromium names them.

Chromium takes AVFoundation's name and, of built-in and USB cameras, the last eight characters of the unique
id: of a USB camera they are vendor and product id, of a built-in one whatever stands there (`0000:0001`).
OpenCV counts the cameras in the order of their unique ids.
Source: media/capture/video/mac/uvc_control_mac.mm of Chromium.
"""

import json
import subprocess
from collections.abc import Sequence

from ..errors import CameraError
from .system import Device, label_of

PLATFORM = "Macintosh; Intel Mac OS X 10_15_7"
"""Chromium's platform on every Macintosh: user agents are reduced."""
CAP_AVFOUNDATION = 1200
LIST_TIMEOUT_S = 20.0

#: models of cameras that are connected without a wire, which Chromium gives no id
_CONTINUITY = ("iPhone", "iPad")


def devices() -> Sequence[Device]:
    """List the cameras. Raises CameraError if the system does not say."""
    try:
        listed = subprocess.run(
            ["/usr/sbin/system_profiler", "SPCameraDataType", "-json"],
            capture_output=True,
            check=True,
            timeout=LIST_TIMEOUT_S,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise CameraError(
            f"macOS does not list its cameras ({type(error).__name__}): open one by index"
        ) from None
    return parse(listed.stdout)


def parse(listed: bytes) -> Sequence[Device]:
    """Read what `system_profiler SPCameraDataType -json` wrote. Raises CameraError for anything else."""
    try:
        entries = json.loads(listed)["SPCameraDataType"]
        cameras = [
            (
                str(entry.get("spcamera_unique-id", "")),
                str(entry["_name"]),
                str(entry.get("spcamera_model-id", "")),
            )
            for entry in entries
        ]
    except (ValueError, KeyError, TypeError, AttributeError):
        raise CameraError("macOS lists its cameras in a form that this version does not know") from None
    return [
        Device(index, label_of(name, _model_id(unique, model)), PLATFORM, unique, CAP_AVFOUNDATION)
        for index, (unique, name, model) in enumerate(sorted(cameras))
    ]


def _model_id(unique: str, model: str) -> str:
    if len(unique) < 8 or model.startswith(_CONTINUITY):
        return ""
    return f"{unique[-8:-4]}:{unique[-4:]}"
