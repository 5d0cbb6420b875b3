"""Guided capture: acceptance rules of one session's views."""

from .decision import Advice, Estimate, Exclusion, ViewDecision
from .ending import MAX_VIEWS, History
from .rules import Capture

__all__ = ["MAX_VIEWS", "Advice", "Capture", "Estimate", "Exclusion", "History", "ViewDecision"]
