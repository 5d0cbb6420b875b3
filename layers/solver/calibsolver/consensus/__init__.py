"""Consensus of calibrations of one camera: agreement between them, and their pooled fit."""

from .agreement import difference
from .pooling import Consensus, Member, Rule, pool

__all__ = ["Consensus", "Member", "Rule", "difference", "pool"]
