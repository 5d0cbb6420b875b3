"""Badge of one camera at one size: an SVG image without script, style sheet or font."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal
from xml.sax.saxutils import escape, quoteattr

from calibdb.lookup.camera_search import best_consensus, count_agreeing, group_by_mode, is_listed
from calibdb.schema import ConsensusDocument
from calibdb.settings import Thresholds

Colour = Literal["green", "amber", "grey"]
_COLOURS: dict[Colour, str] = {"green": "#2a6b2f", "amber": "#8a5a00", "grey": "#5d6468"}
_BADGE_FILE = re.compile(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})\.svg")
_USB_ID_END = re.compile(r"\s*\([0-9a-f]{4}:[0-9a-f]{4}\)\s*$", re.IGNORECASE)
_MAX_SHOWN_LENGTH = 40
_NARROW, _WIDE = frozenset("fijlrt.,:;'|!()[] "), frozenset("mwMW@%ABCDEFGHKNOQRSUVXYZ±×")


@dataclass(frozen=True)
class Badge:
    """Text of a badge, left and right."""

    camera: str
    state: str
    colour: Colour


NOT_CALIBRATED = Badge("calibDB", "not calibrated", "grey")


def parse_size(text: str) -> tuple[int, int] | None:
    """Size in `1280x720.svg`, None in other texts."""
    match = _BADGE_FILE.fullmatch(text)
    return (int(match[1]), int(match[2])) if match else None


def badge_of(
    camera: str,
    documents: Sequence[ConsensusDocument],
    img_size: tuple[int, int],
    thresholds: Thresholds,
) -> Badge:
    """Badge of the camera with this label at a size.

    A camera that no search shows has no name.
    """
    if not is_listed(documents, thresholds.min_contributors):
        return NOT_CALIBRATED
    name = without_usb_id(camera)
    short = name if len(name) <= _MAX_SHOWN_LENGTH else name[: _MAX_SHOWN_LENGTH - 1] + "…"
    left = f"{short} {img_size[0]}×{img_size[1]}"
    here = [consensuses for (size, _), consensuses in group_by_mode(documents) if size == img_size]
    if not here:
        return Badge(left, "not calibrated", "grey")
    best = best_consensus([best_consensus(consensuses) for consensuses in here])
    if not best.reliable or best.calibration is None:
        return Badge(left, f"{count_agreeing(best)} of {thresholds.min_calibrations} calibrations", "amber")
    return Badge(left, f"calibrated ± {rough(best.calibration.uncertainty.rms)} px", "green")


def svg(badge: Badge) -> str:
    """Draw the badge: every text is escaped, and has the same width in every font."""
    left, right = _width(badge.camera) + 12, _width(badge.state) + 12
    total = left + right
    title = f"{badge.camera}: {badge.state}"

    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{total}" height="20" viewBox="0 0 {total} 20"'
        f' role="img" aria-label={quoteattr(title)}><title>{escape(title)}</title>'
        f'<rect width="{total}" height="20" rx="3" fill="#2b3032"/>'
        f'<path d="M{left} 0h{right - 3}a3 3 0 0 1 3 3v14a3 3 0 0 1 -3 3h-{right - 3}z"'
        f' fill="{_COLOURS[badge.colour]}"/>'
        '<g fill="#ffffff" font-family="Verdana,Geneva,DejaVu Sans,sans-serif" font-size="11">'
        f"{_text(badge.camera, 6, left - 12)}{_text(badge.state, left + 6, right - 12)}</g></svg>"
    )


def without_usb_id(label: str) -> str:
    """Label without the USB id that Chromium appends."""
    return _USB_ID_END.sub("", label)


def _text(words: str, x: int, width: int) -> str:
    place = f'x="{x}" y="14" textLength="{width}" lengthAdjust="spacingAndGlyphs"'
    return f"<text {place}>{escape(words)}</text>"


def _width(words: str) -> int:
    """Approximate width in Verdana at 11 px."""
    return round(sum(4.2 if c in _NARROW else 8.4 if c in _WIDE else 6.9 for c in words))


def rough(value: float) -> str:
    """Write a positive length to hundredths, a smaller one to one significant digit."""
    if value < 0.01:
        return f"{value:.1g}"
    return f"{value:.2f}" if value < 0.995 else f"{value:.1f}" if value < 9.95 else f"{value:.0f}"
