"""Guidance: three ways to choose the next-best view."""

from .pose_selection import PoseSelection
from .posterior import MIN_NOISE_WIDTHS, IntrinsicsPosterior
from .projection_uncertainty import ProjectionUncertainty, fixed_plan
from .target import TargetPose

GUIDES: dict[str, type[ProjectionUncertainty] | type[PoseSelection]] = {
    "projection-uncertainty": ProjectionUncertainty,
    "pose-selection": PoseSelection,
}

__all__ = [
    "GUIDES",
    "MIN_NOISE_WIDTHS",
    "IntrinsicsPosterior",
    "PoseSelection",
    "ProjectionUncertainty",
    "TargetPose",
    "fixed_plan",
]
