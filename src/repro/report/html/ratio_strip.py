"""A number against the printed one, drawn: the tolerance as a band, our median as a dot on its interval."""

import math
from typing import TYPE_CHECKING

from repro.claims.verdicts import Verdict
from repro.report import writing

if TYPE_CHECKING:
    from markupsafe import Markup

DECADES = 3  # each way from the printed value
WIDTH, HEIGHT = 132, 18


def ratio_strip(verdict: Verdict) -> "Markup | None":
    """Return an SVG on a log scale of ours / printed, 0.001 to 1000; None where there is nothing to compare."""
    from markupsafe import Markup

    printed, found = verdict.claim.printed, verdict.estimate
    if printed is None or printed <= 0 or not found.n or not found.median > 0:
        return None
    ratio = found.median / printed
    middle = HEIGHT / 2
    parts = [f'<line class="axis" x1="0" x2="{WIDTH}" y1="{middle}" y2="{middle}"/>']
    if verdict.claim.tolerance is not None:
        low, high = (_place(end / printed) for end in verdict.claim.tolerance.around(printed))
        parts.append(f'<rect class="band" x="{low:.1f}" width="{high - low:.1f}" y="2" height="{HEIGHT - 4}"/>')
    parts.append(f'<line class="one" x1="{_place(1):.1f}" x2="{_place(1):.1f}" y1="1" y2="{HEIGHT - 1}"/>')
    if found.low > 0 and math.isfinite(found.high):
        ends = [_place(end / printed) for end in (found.low, found.high)]
        parts.append(f'<line class="interval" x1="{ends[0]:.1f}" x2="{ends[1]:.1f}" y1="{middle}" y2="{middle}"/>')
    parts.append(_mark(ratio, middle))
    label = f"ours is {writing.number(ratio)} times the printed value"
    drawing = "".join(parts)
    return Markup(f'<svg class="strip" role="img" aria-label="{label}" viewBox="0 0 {WIDTH} {HEIGHT}">{drawing}</svg>')


def _mark(ratio: float, middle: float) -> str:
    """A dot; beyond the scale, an arrow head at its end."""
    if abs(math.log10(ratio)) <= DECADES:
        return f'<circle cx="{_place(ratio):.1f}" cy="{middle}" r="3.5"/>'
    tip, back = (WIDTH, WIDTH - 8) if ratio > 1 else (0, 8)
    return f'<polygon points="{tip},{middle} {back},{middle - 4.5} {back},{middle + 4.5}"/>'


def _place(ratio: float) -> float:
    if ratio <= 0:
        return 0.0
    decades = min(max(math.log10(ratio), -DECADES), DECADES)
    return WIDTH * (0.5 + 0.5 * decades / DECADES)
