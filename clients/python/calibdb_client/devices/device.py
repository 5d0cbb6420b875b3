"""One camera of this machine."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Device:
    """A camera that is connected, under the label and platform that Chromium gives it.

    OpenCV opens it by `index` at the interface `backend`, 0: any. `path` is its path or unique id in the
    system.
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
