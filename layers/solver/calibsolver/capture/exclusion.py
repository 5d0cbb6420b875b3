"""Exclusion of accepted views that contradict others."""

from collections.abc import Mapping, Sequence
from functools import partial

from .. import deadline
from ..view import View
from .consistency import MAX_OUTVOTED_VIEWS, Consistency
from .decision import EXCLUDED_MINORITY, EXCLUDED_OUTLIER, Exclusion

MAX_CONFLICT_S = 1.0
"""Time to find the views that conflict with others, if the time is limited."""


def resolve_conflict(
    consistency: Consistency,
    views: Sequence[View],
    view: View,
    excluded: Mapping[int, Exclusion],
    quarantined: Sequence[View],
) -> dict[int, Exclusion] | None:
    """Exclusions of `views` that let `view` stay; None if `view` itself is wrong."""
    active = [i for i in range(len(views)) if i not in excluded]

    def resolve() -> dict[int, Exclusion] | None:
        if not active or not consistency.is_consistent([], view):
            return None
        wrong = consistency.find_conflicting_view([views[i] for i in active], view)
        if wrong is not None:
            return {**excluded, active[wrong]: EXCLUDED_OUTLIER}
        outvoted = min(len(active), MAX_OUTVOTED_VIEWS)
        group = consistency.find_consistent_views(view, [*quarantined, *views], outvoted)
        if len(group) <= outvoted:
            return None
        members = {id(member) for member in group}
        return {
            i: excluded.get(i, EXCLUDED_MINORITY) for i, other in enumerate(views) if id(other) not in members
        }

    return deadline.compute_within(MAX_CONFLICT_S, resolve, None)


def exclude_outliers(
    consistency: Consistency, views: Sequence[View], excluded: Mapping[int, Exclusion]
) -> dict[int, Exclusion]:
    """Exclusions with the views that are not consistent with the others."""
    result = dict(excluded)
    while True:
        active = [i for i in range(len(views)) if i not in result]
        remaining = [views[i] for i in active]
        wrong = deadline.compute_within(
            MAX_CONFLICT_S, partial(consistency.find_outlier_view, remaining), None
        )
        if wrong is None:
            return result
        result[active[wrong]] = EXCLUDED_OUTLIER
