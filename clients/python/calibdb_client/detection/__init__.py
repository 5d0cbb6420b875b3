"""Boards in pictures, by OpenCV. The pictures go nowhere."""

from .corners import Corners
from .detector import Detector
from .recognition import recognise

__all__ = ["Corners", "Detector", "recognise"]
