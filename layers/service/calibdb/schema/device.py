"""Model identifier of a phone: a part of its platform that the caller names."""

from __future__ import annotations

from typing import Annotated, Protocol

from pydantic import Field

from calibdb.camera_key.system import with_device
from calibdb.schema.fields import MAX_LABEL

DeviceModel = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9][\w ()+.,&-]*$")]
DEVICE_TEXT = (
    "Model identifier of the phone, `iPhone17,3`, if label and platform do not name the model. It becomes a "
    "part of `platform`, and so of the camera's key."
)


class Named(Protocol):
    """Request that names a platform, and perhaps a device."""

    @property
    def platform(self) -> str:
        """Platform of the camera."""

    @property
    def device(self) -> str | None:
        """Model identifier."""


def join_device(request: Named) -> None:
    """Make the device that a request names a part of its platform."""
    if request.device is None:
        return
    joined = with_device(request.platform, request.device)
    if len(joined) <= MAX_LABEL:
        object.__setattr__(request, "platform", joined)  # the model is frozen from here on
