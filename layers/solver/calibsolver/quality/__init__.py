"""Quality of a calibration."""

from .assessment import Assessment, assess
from .cross_validation import HeldOut, held_out
from .model_selection import suggest_model

__all__ = ["Assessment", "HeldOut", "assess", "held_out", "suggest_model"]
