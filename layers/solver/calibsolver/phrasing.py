"""Figures as people are told them: where a number says nothing any more, in words."""

HUNDRED = 100.0


def off(px: float, width: float, digits: int = 1) -> str:
    """Distance in words, px, in an image of this width, px: beyond that no number says more."""
    return f"{px:.{digits}f} px off" if px < width else "off by more than the image is wide"


def times(factor: float) -> str:
    """Phrase a number of times."""
    return f"{factor:.1f} times" if factor < HUNDRED else "over a hundred times"
