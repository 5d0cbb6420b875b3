"""Counts of lookups of cameras that are not known: `ASKED#<week>/CAMERA#<camera>`, for three months.

A camera is its key, if enough contributors calibrated it, or `usb#<vid:pid>`. No label or source is stored.
"""

from collections import Counter
from collections.abc import Mapping

from calibdb.store.ports import ItemStore

USB = "usb#"
WEEKS = 13  # that are counted: 90 days, about
MAX_CAMERAS_A_WEEK = 10_000  # that are read; invented ones beyond add nothing
_WEEK_S = 7 * 86_400
_CAMERA = "CAMERA#"


class MissCounts(ItemStore):
    """Counters of lookups that found nothing reliable."""

    def add(self, counts: Mapping[str, int], now: int) -> None:
        """Add to the counters of this week."""
        week = now // _WEEK_S
        ttl = (week + WEEKS) * _WEEK_S
        for camera, count in counts.items():
            self._table.add(_pk(week), _CAMERA + camera, "asked", count, ttl=ttl)

    def most(self, now: int) -> list[tuple[str, int]]:
        """Return cameras and their counts, largest first."""
        total: Counter[str] = Counter()
        for week in range(now // _WEEK_S - WEEKS + 1, now // _WEEK_S + 1):
            for item in self._table.query(_pk(week), _CAMERA, limit=MAX_CAMERAS_A_WEEK):
                total[item["sk"].removeprefix(_CAMERA)] += item["asked"]
        return sorted(total.items(), key=lambda found: (-found[1], found[0]))


def _pk(week: int) -> str:
    return f"ASKED#{week}"
