"""Boards in pictures, by OpenCV: their corners, and which board it is. The pictures go nowhere."""

from .corners import Corners
from .detector import Detector
from .recognition import recognise

__all__ = ["Corners", "Detector", "recognise"]
