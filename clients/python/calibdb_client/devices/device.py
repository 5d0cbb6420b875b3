"""One camera of this machine."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Device:
    """A camera that is connected.

    Attributes
    ----------
    index
        Number by which OpenCV opens it.
    label, platform
        As Chromium gives them: the name, then the USB id in brackets if there is one.
    path
        Path or unique id in the system.
    backend
        OpenCV's number of the interface that counts it under `index`; 0: any.
    """

    index: int
    label: str
    platform: str
    path: str = ""
    backend: int = 0


def label_of(name: str, model_id: str) -> str:
    """Return the label of a name and a USB id `vid:pid` or "", as Chromium joins them."""
    name = name.strip()
    suffix = f" ({model_id})" if model_id else ""
    return name if name.endswith(suffix) else name + suffix
