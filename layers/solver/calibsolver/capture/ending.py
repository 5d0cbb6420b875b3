"""End of a capture: when another view would hardly help, or nothing new is shown.

The thresholds were chosen on 14 sets of real corners and 5 videos. `make bench DOCS=capture` shows them.
"""

from dataclasses import dataclass
from typing import Literal

EndReason = Literal["target", "plateau", "limit", "nothing_new", "asked"]

MIN_VIEWS = 4
"""Views that count before a capture may end: fewer can agree by chance."""
MAX_VIEWS = 15
"""Views that count with which a capture ends at the error reached so far."""
MIN_PLATEAU_VIEWS = 10
"""Views that count before the stated error may have reached its plateau."""
PLATEAU_SPAN = 3
MIN_PROGRESS = 0.85
"""Smallest stated error / the smallest `PLATEAU_SPAN` views earlier, above which there is no progress."""
MAX_ABOVE_BEST = 1.3
"""Stated error / the smallest so far, up to which a capture ends at a plateau."""
MAX_DUPLICATES = 6


@dataclass(frozen=True)
class History:
    """Course of a capture so far.

    `stated`: px, error after each accepted view, None without a fit. `on_target`: whether each was held at
    its target. `duplicates`: views refused as such since the last accepted one.
    """

    stated: tuple[float | None, ...] = ()
    on_target: tuple[bool, ...] = ()
    duplicates: int = 0

    def with_view(self, on_target: bool, stated: float | None = None) -> "History":
        """History with one more accepted view."""
        return History((*self.stated, stated), (*self.on_target, on_target))

    def has_plateau(self, stated: float, count: int) -> bool:
        """True if the error, `stated` after the last view, has stopped falling; `count` views count."""
        smallest: list[float] = []
        for error in (*self.stated[MIN_VIEWS - 1 : -1], stated):
            smallest.append(min([*smallest[-1:], float("inf") if error is None else error]))
        return (
            count >= MIN_PLATEAU_VIEWS
            and len(smallest) > PLATEAU_SPAN
            and smallest[-1] > MIN_PROGRESS * smallest[-1 - PLATEAU_SPAN]
            and stated <= MAX_ABOVE_BEST * smallest[-1]
            and all(self.on_target[-PLATEAU_SPAN:])
        )

    def is_exhausted(self, count: int) -> bool:
        """True if nothing new is shown; `count` views count."""
        return count >= MIN_VIEWS and self.duplicates >= MAX_DUPLICATES


NO_HISTORY = History()
