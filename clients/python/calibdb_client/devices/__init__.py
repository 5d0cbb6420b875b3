"""Cameras of this machine, under the labels that Chromium gives them."""

from .system import Device, devices, find, platform_of

__all__ = ["Device", "devices", "find", "platform_of"]
