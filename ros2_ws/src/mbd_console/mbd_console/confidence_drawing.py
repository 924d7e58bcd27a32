"""The confidence over time against the threshold, as SVG."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbd_console.palette import BAD, GOOD, INFERRED, safe
from mbd_console.state import Confidence
from mbd_console.words.texts import ENGLISH, PageTexts

SIZE, LEFT, RIGHT, TOP, BOTTOM = (380.0, 170.0), 52.0, 10.0, 12.0, 30.0  # [units of the drawing]


def confidence_drawing(points: Sequence[Confidence], threshold: float, texts: PageTexts = ENGLISH) -> str:
    """SVG: one dot an inference with the number of assists it came of, the threshold dashed.

    Args:
        points: in the order received.
        threshold: from which on the robot goes on alone.
        texts: in which language.
    """
    width, height = SIZE
    top = _nice_ceiling(1.15 * max([threshold, *(p.value for p in points), 0.05]))
    first, last = (points[0].at, points[-1].at) if points else (0.0, 0.0)

    def x(at: float) -> float:
        share = (at - first) / (last - first) if last > first else 0.0
        return LEFT + 16 + share * (width - LEFT - RIGHT - 34)

    def y(value: float) -> float:
        # Square root: thresholds are small beside the confidences that pass them, and both must be legible.
        return TOP + (1 - math.sqrt(max(value, 0.0) / top)) * (height - TOP - BOTTOM)

    marks = "".join(
        f'<line class="grid" x1="{LEFT:g}" x2="{width - RIGHT:g}" y1="{y(v):.1f}" y2="{y(v):.1f}"/>'
        f'<text class="tick" x="{LEFT - 6:g}" y="{y(v) + 4:.1f}" text-anchor="end">{v:.2g}</text>'
        for v in (0.0, top / 4, top)
    )
    limit = _limit(threshold, y(threshold), texts) if points else ""
    line = " ".join(f"{x(p.at):.1f},{y(p.value):.1f}" for p in points)
    path = f'<polyline class="curve" points="{line}" stroke="{INFERRED}"/>' if points else ""
    dots = "".join(_dot(p, x(p.at), y(p.value), p.value >= threshold) for p in points)
    ticks = "".join(
        f'<text class="tick" x="{x(p.at):.1f}" y="{height - 7:g}" text-anchor="middle">{p.num_assists}</text>'
        for n, p in enumerate(points)
        if n == len(points) - 1 or x(points[n + 1].at) - x(p.at) > 12
    )
    axis = f'<text class="axis" x="{LEFT:g}" y="{height - 7:g}" text-anchor="end">{safe(texts("axis_assists"))}</text>'
    empty = (
        ""
        if points
        else f'<text class="empty" x="{width / 2:g}" y="{height / 2:g}">{safe(texts("no_estimate"))}</text>'
    )
    drawn = f"{marks}{limit}{path}{dots}{axis}{ticks}{empty}"
    values = ", ".join(f"{p.value:.2g}" for p in points) or texts("nothing_yet")
    label = safe(texts("confidence_label", values=values))
    return f'<svg class="confidence" role="img" aria-label="{label}" viewBox="0 0 {width:g} {height:g}">{drawn}</svg>'


def _limit(threshold: float, y: float, texts: PageTexts) -> str:
    # Above the line, or below it where it would leave the drawing.
    beside = y - 6 if y > TOP + 12 else y + 14
    return (
        f'<line class="limit" x1="{LEFT:g}" x2="{SIZE[0] - RIGHT:g}" y1="{y:.1f}" y2="{y:.1f}" stroke="{BAD}"/>'
        f'<text class="limittext" x="{LEFT + 6:g}" y="{beside:.1f}" fill="{BAD}">'
        f"{safe(texts('threshold', value=f'{threshold:.3g}'))}</text>"
    )


def _dot(point: Confidence, x: float, y: float, sure: bool) -> str:
    color = GOOD if sure else INFERRED
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5.5" fill="{color}" data-confidence="{point.value:.6f}">'
        f"<title>{point.value:.4f} after {point.num_assists} assists</title></circle>"
    )


def _nice_ceiling(value: float) -> float:
    """The next of 1, 2, 4, 5 times a power of ten, at most 1."""
    power = 10.0 ** math.floor(math.log10(value))
    return min(1.0, next((k * power for k in (1, 2, 4, 5) if k * power >= value), 10 * power))
