"""Guided capture: acceptance rules of one session's views."""

from .advice import Advice
from .decision import Estimate, SetAside, Verdict
from .rules import MAX_VIEWS, Capture

__all__ = ["MAX_VIEWS", "Advice", "Capture", "Estimate", "SetAside", "Verdict"]
