"""Phrases for figures in sentences: words instead of meaningless numbers."""

MAX_FACTOR = 100.0
"""Factor from which on a number says nothing more."""


def format_px_error(px: float, width: float, digits: int = 1) -> str:
    """Format an error, px, in an image of some width, px: beyond the width no number says more."""
    return f"{px:.{digits}f} px off" if px < width else "off by more than the image is wide"


def format_factor(factor: float) -> str:
    """Format a factor as how many times."""
    return f"{factor:.1f} times" if factor < MAX_FACTOR else "over a hundred times"
