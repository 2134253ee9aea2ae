"""How numbers are written for people: three significant figures; and text as a cell of a Markdown table."""

import math
import re

from markdown_it import MarkdownIt

from repro.results.statistics import Estimate

ABSENT = "–"
COMMONMARK = MarkdownIt("commonmark", {"html": False})  # of the report's texts; HTML inside them is text


def number(value: float | None) -> str:
    """Write a number with three significant figures: 0.26, 39.4, 1420, 5.3e-4."""
    if value is None or math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.0f}" if abs(value) >= 999.5 else f"{value:.3g}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"


def interval(estimate: Estimate) -> str:
    """Write a median with its interval: 0.21 [0.15, 0.31]; the interval is left out where there is none."""
    if math.isnan(estimate.low) or math.isnan(estimate.high):
        return number(estimate.median)
    return f"{number(estimate.median)} [{number(estimate.low)}, {number(estimate.high)}]"


def value(content: object) -> str:
    """Write a value of any kind: text as it is, an estimate with its interval."""
    if isinstance(content, Estimate):
        return interval(content)
    return number(content) if content is None or isinstance(content, float) else str(content)


def markdown(text: str) -> str:
    """Escape text for a Markdown table cell."""
    escaped = re.sub(r"([\\|*_<\[\]])", r"\\\1", text)
    return escaped.replace("\n", " ")
