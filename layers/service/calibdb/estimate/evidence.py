"""Evidence about a field of view, and its combination."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from calibdb.schema.estimate import EstimateBasis, Source

_FREEDOM = 4.0  # degrees of freedom of the t distribution
_ROUNDS = 12
_OUTLYING = 3.0  # standard deviations
_MAJORITY = 0.6  # of the statements, weighted by 1 / sigma


@dataclass(frozen=True)
class Evidence:
    """One statement about `log_tan` along the longer side."""

    basis: EstimateBasis
    mean: float
    sigma: float
    sources: tuple[Source, ...] = ()
    lens: tuple[float, ...] = ()  # coefficients of a fisheye lens

    def shifted(self, change: float, sigma: float) -> Evidence:
        """Evidence at another zoom or size."""
        return replace(self, mean=self.mean + change, sigma=math.hypot(self.sigma, sigma))


def combine(evidence: Sequence[Evidence]) -> tuple[float, float]:
    """Mean and standard deviation, weighted by precision and a t distribution; contradictions widen it."""
    mean = _weighted_median(evidence)
    weights = [1.0] * len(evidence)
    for _ in range(_ROUNDS):
        weights = [(_FREEDOM + 1) / (_FREEDOM + ((e.mean - mean) / e.sigma) ** 2) for e in evidence]
        precisions = [min(weight, 1.0) / e.sigma**2 for weight, e in zip(weights, evidence, strict=True)]
        total = sum(precisions)
        mean = sum(p * e.mean for p, e in zip(precisions, evidence, strict=True)) / total
    agreeing = sum(1 / e.sigma for e in evidence if abs(e.mean - mean) < _OUTLYING * e.sigma)
    if agreeing < _MAJORITY * sum(1 / e.sigma for e in evidence):
        # Without a majority any of them may be right.
        return mixture([(1 / e.sigma, e.mean, e.sigma) for e in evidence])
    chi2 = sum(p * (e.mean - mean) ** 2 for p, e in zip(precisions, evidence, strict=True))
    inflation = math.sqrt(max(1.0, chi2 / max(1, len(evidence) - 1)))
    return mean, inflation / math.sqrt(total)


def mixture(parts: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Mean and standard deviation of alternatives `(weight, mean, sigma)`."""
    total = sum(weight for weight, _, _ in parts)
    mean = sum(weight * part for weight, part, _ in parts) / total
    variance = sum(weight * (sigma**2 + (part - mean) ** 2) for weight, part, sigma in parts) / total
    return mean, math.sqrt(variance)


def _weighted_median(evidence: Sequence[Evidence]) -> float:
    """Median by 1 / sigma: one very precise statement does not outweigh several others."""
    ordered = sorted(evidence, key=lambda e: e.mean)
    half = sum(1 / e.sigma for e in ordered) / 2
    below = itertools.accumulate(1 / e.sigma for e in ordered)
    return next(e.mean for e, weight in zip(ordered, below, strict=True) if weight >= half)
