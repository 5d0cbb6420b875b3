"""Guidance: three ways to choose the next-best view."""

from .fixed_plan import fixed_plan
from .pose_selection import PoseSelection
from .posterior import MIN_NOISE_WIDTHS, IntrinsicsPosterior
from .projection_uncertainty import ProjectionUncertainty
from .target import TargetPose

GUIDES: dict[str, type[ProjectionUncertainty] | type[PoseSelection]] = {
    "projection-uncertainty": ProjectionUncertainty,
    "pose-selection": PoseSelection,
}
"""Guidance by the name that a session is started with; the first is the default."""

__all__ = [
    "GUIDES",
    "MIN_NOISE_WIDTHS",
    "IntrinsicsPosterior",
    "PoseSelection",
    "ProjectionUncertainty",
    "TargetPose",
    "fixed_plan",
]
