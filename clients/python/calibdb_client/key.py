"""Camera key: label, platform, picture size and zoom, which identify a camera's optics."""

from __future__ import annotations

import hashlib
import math
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

from .errors import UsageError

MODELS = ("rectilinear", "fisheye", "rational", "omnidirectional")
DEFAULT_MODEL = MODELS[0]
AUTO = "auto"
"""The distortion model that explains the views best."""
UNNAMED = "unnamed camera"
"""Label of a camera that has none."""


@runtime_checkable
class HasLabel(Protocol):
    """An open camera, or one of the list of cameras, under the label and platform that Chromium gives."""

    @property
    def label(self) -> str:
        """Label as Chromium gives it."""

    @property
    def platform(self) -> str:
        """Platform as Chromium gives it."""


@dataclass(frozen=True)
class CameraKey:
    """Identity of a camera's optics.

    Attributes
    ----------
    camera
        `MediaStreamTrack.label`, such as ``HD Pro Webcam C920 (046d:082d)``.
    platform
        The parenthesised part of the user agent, such as ``X11; Linux x86_64``.
    img_size
        Width and height of the picture, px.
    zoom
        The track's zoom; 0 if the camera has none.

    Raises UsageError for values that no camera has.
    """

    camera: str
    platform: str
    img_size: tuple[int, int]
    zoom: float = 0.0

    def __post_init__(self) -> None:
        if not self.camera.strip() or not self.platform.strip():
            raise UsageError("a camera has a label and a platform: neither may be empty")
        w, h = (int(side) for side in self.img_size)
        if not (16 <= w <= 16384 and 16 <= h <= 16384):
            raise UsageError(f"a picture has 16 to 16384 px a side, not {w} x {h}")
        if not (math.isfinite(self.zoom) and 0 <= self.zoom <= 1e6):
            raise UsageError(f"a zoom lies in 0 to 1000000, not {self.zoom}")
        object.__setattr__(self, "img_size", (w, h))
        object.__setattr__(self, "zoom", float(self.zoom))

    def with_device(self, device: str | None) -> CameraKey:
        """Return the key with a phone's model identifier as a part of its platform."""
        parts = [part.strip().casefold() for part in self.platform.split(";")]
        if not device or device.casefold() in parts:
            return self
        return replace(self, platform=f"{self.platform}; {device}")

    def record(self) -> dict[str, Any]:
        """Return the key as the members of a request."""
        return {
            "camera": self.camera,
            "platform": self.platform,
            "img_size": list(self.img_size),
            "zoom": self.zoom,
        }

    def known_path(self, model: str = DEFAULT_MODEL) -> str | None:
        """Return the path of the lookup without a credential; None if there is none.

        The digest is half of a SHA-256, so that no label stands in an address (docs/api.md).
        """
        zoom = zoom_text(self.zoom)
        if zoom is None:
            return None
        w, h = self.img_size
        label = unicodedata.normalize("NFC", self.camera).strip()
        digest = hashlib.sha256(f"v1\n{label}\n{self.platform}".encode()).hexdigest()[:32]
        return f"known/v1/{digest}/{w}x{h}/{zoom}/{model}.json"


def zoom_text(zoom: float) -> str | None:
    """Write a zoom to six decimals without zeros at the end; None if it has more."""
    text = f"{zoom:.6f}"
    return text.rstrip("0").rstrip(".") if float(text) == zoom else None


def key_of(
    camera: CameraKey | HasLabel | str,
    platform: str | None = None,
    size: Sequence[int] | None = None,
    zoom: float | None = None,
) -> CameraKey:
    """Return the key of an open camera, a listed one, or a label.

    The other arguments, sizes in px, replace what the camera knows. A bare label needs a platform, a camera
    that is not open a size.

    Raises UsageError if something is missing.
    """
    if isinstance(camera, str):
        label, known_platform, known_size, known_zoom = camera, None, None, 0.0
    elif isinstance(camera, CameraKey):
        label, known_platform = camera.camera, camera.platform
        known_size, known_zoom = camera.img_size, camera.zoom
    elif isinstance(camera, HasLabel):
        label, known_platform = camera.label, camera.platform
        known_size, known_zoom = getattr(camera, "img_size", None), float(getattr(camera, "zoom", 0.0))
    else:
        raise UsageError("this camera has no label: give a CameraKey of label, platform and size")
    platform, chosen = platform or known_platform, size or known_size
    if not platform:
        raise UsageError(f"of {label!r} the platform is missing, such as 'X11; Linux x86_64'")
    if not chosen:
        raise UsageError(f"of {label!r} the size of the picture is missing, such as (1280, 720)")
    w, h = chosen
    return CameraKey(label, platform, (int(w), int(h)), known_zoom if zoom is None else zoom)


def checked_model(model: str) -> str:
    """Return the name of a distortion model. Raises UsageError for an unknown one."""
    if model not in MODELS:
        raise UsageError(f"a distortion model is one of {', '.join(MODELS)}, not {model!r}")
    return model


def live_model(model: str) -> str:
    """Return the model by which a live capture is guided. Raises UsageError for an unknown one."""
    return DEFAULT_MODEL if model == AUTO else checked_model(model)
