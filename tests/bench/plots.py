"""Small line plots as SVG: labelled axes, logarithmic where asked, readable on light and dark pages."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

WIDTH, HEIGHT = 640, 360
LEFT, RIGHT, TOP, BOTTOM = 62, 190, 16, 46
COLORS = ("#c26a00", "#2f6fb0", "#3d8a4e", "#8a4f9e", "#777777", "#b03a3a")


@dataclass(frozen=True)
class Line:
    """A named line: points (x, y), and the upper edge of its band at each x where there is one."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    upper: Sequence[float] = ()


def plot(lines: Sequence[Line], across: str, up: str, ticks: Sequence[float]) -> str:
    """SVG of `lines` over a linear x and a logarithmic y axis with its `ticks`."""
    xs = [x for line in lines for x in line.x]
    low, high = min(xs), max(xs)
    bottom, top = math.log(ticks[0]), math.log(ticks[-1])

    def place(x: float, y: float) -> str:
        share = (math.log(min(max(y, ticks[0]), ticks[-1])) - bottom) / (top - bottom)
        return (
            f"{LEFT + (x - low) / (high - low) * (WIDTH - LEFT - RIGHT):.1f},"
            f"{HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM):.1f}"
        )

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
        f'font-size="13"><rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>'
    ]
    for y in ticks:
        x0, y0 = place(low, y).split(",")
        out.append(
            f'<path d="M{x0},{y0}H{WIDTH - RIGHT}" stroke="#ddd"/>'
            f'<text x="{LEFT - 8}" y="{float(y0) + 4:.1f}" text-anchor="end">{y:g}</text>'
        )
    for x in sorted(set(xs)):
        x0, y0 = place(x, ticks[0]).split(",")
        out.append(f'<text x="{x0}" y="{float(y0) + 18:.1f}" text-anchor="middle">{x:g}</text>')
    for i, line in enumerate(lines):
        color = COLORS[i % len(COLORS)]
        points = " ".join(place(x, y) for x, y in zip(line.x, line.y, strict=True))
        out.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2.5"/>')
        if line.upper:
            edge = " ".join(place(x, y) for x, y in zip(line.x, line.upper, strict=True))
            out.append(
                f'<polyline points="{edge}" fill="none" stroke="{color}" stroke-width="1.2" '
                f'stroke-dasharray="4 3"/>'
            )
        y = TOP + 16 + 22 * i
        out.append(
            f'<path d="M{WIDTH - RIGHT + 14},{y - 4}h18" stroke="{color}" stroke-width="2.5"/>'
            f'<text x="{WIDTH - RIGHT + 38}" y="{y}">{escape(line.name)}</text>'
        )
    center, middle = (LEFT + WIDTH - RIGHT) / 2, (HEIGHT - BOTTOM + TOP) / 2
    out.append(
        f'<text x="{center}" y="{HEIGHT - 8}" text-anchor="middle">{escape(across)}</text>'
        f'<text transform="translate(16 {middle}) rotate(-90)" text-anchor="middle">{escape(up)}</text>'
        "</svg>\n"
    )
    return "\n".join(out)
