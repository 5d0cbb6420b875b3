"""Use of a token by hour and by day, summed up from its counters."""

from __future__ import annotations

import time
from collections.abc import Mapping

from calibdb.access.plans import HOUR_S, KINDS
from calibdb.schema.managed_token import DayOfUse, HourOfUse, TokenUse

HOURS, DAYS = 48, 30
_DAY_S = 24 * HOUR_S


def summary(counts: Mapping[str, Mapping[str, int]], now: int) -> TokenUse:
    """Sum up counters by hour (`2026-11-22T16`, UTC): the last 48 hours, and the last 30 days."""
    hours = [_text("%Y-%m-%dT%H", now - back * HOUR_S) for back in reversed(range(HOURS))]
    days = [_text("%Y-%m-%d", now - back * _DAY_S) for back in reversed(range(DAYS))]
    by_day: dict[str, dict[str, int]] = {day: dict.fromkeys(KINDS, 0) for day in days}
    for hour, used in counts.items():
        day = by_day.get(hour[:10])
        if day is not None:
            for kind in KINDS:
                day[kind] += used.get(kind, 0)
    return TokenUse(
        hours=tuple(HourOfUse(hour=hour, **_by_kind(counts.get(hour, {}))) for hour in hours),
        days=tuple(DayOfUse(day=day, **by_day[day]) for day in days),
    )


def _by_kind(used: Mapping[str, int]) -> dict[str, int]:
    return {kind: used.get(kind, 0) for kind in KINDS}


def _text(form: str, now: int) -> str:
    return time.strftime(form, time.gmtime(now))
