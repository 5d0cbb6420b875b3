"""Quality of a calibration: prediction, cross-validation, model selection, assessment, report."""

from .assessment import Assessment, assess
from .cross_validation import HeldOut, held_out
from .model_selection import suggest_model
from .report import describe

__all__ = ["Assessment", "HeldOut", "assess", "describe", "held_out", "suggest_model"]
