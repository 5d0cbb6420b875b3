"""Guidance: three methods to choose the next target pose."""

from .belief import LEAST_NOISE, Belief
from .fixed_plan import FixedPlan
from .guide import Guide
from .pose_selection import PoseSelection
from .projection_uncertainty import ProjectionUncertainty
from .target import TargetPose

GUIDES: dict[str, type[ProjectionUncertainty] | type[PoseSelection]] = {
    "projection-uncertainty": ProjectionUncertainty,
    "pose-selection": PoseSelection,
}
"""By the names that a session is started with; the first is the default."""

__all__ = [
    "GUIDES",
    "LEAST_NOISE",
    "Belief",
    "FixedPlan",
    "Guide",
    "PoseSelection",
    "ProjectionUncertainty",
    "TargetPose",
]
