"""Cameras of this machine, under the labels that Chromium gives them."""

from .device import Device
from .system import devices, find, platform_of

__all__ = ["Device", "devices", "find", "platform_of"]
