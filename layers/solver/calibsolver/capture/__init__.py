"""Guided capture: acceptance rules of one session's views."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .decision import Advice, Estimate, Exclusion, ViewDecision
    from .ending import MAX_VIEWS, History
    from .rules import Capture

_MODULES = {
    "Advice": "decision",
    "Capture": "rules",
    "Estimate": "decision",
    "Exclusion": "decision",
    "History": "ending",
    "MAX_VIEWS": "ending",
    "ViewDecision": "decision",
}

__all__ = ["MAX_VIEWS", "Advice", "Capture", "Estimate", "Exclusion", "History", "ViewDecision"]


def __getattr__(name: str) -> Any:
    """Import a name when it is first used: `admission` needs neither guidance nor quality."""
    if name in _MODULES:
        return getattr(import_module(f".{_MODULES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
