"""A training step of the inverse model beside those of LNN, DeLaN and LINN: naive code, and the fastest engine."""

from typing import TYPE_CHECKING

from repro.report.figures.figure import Figure
from repro.report.figures.timing import draw_pairs
from repro.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

RIVALS = r"(lnn|delan|linn)_(naive|automatic|best)"


def draw(results: Results) -> "Canvas | None":
    """Draw one row per rival and way of writing it, one marker per size of the network."""
    bench = results.bench
    return draw_pairs(bench[bench["name"].str.fullmatch(RIVALS)])


FIGURES = (
    Figure(
        "rivals",
        "A training step beside those of LNN, DeLaN and LINN",
        "Medians and quartiles of paired, interleaved timings of one thread, one marker per size of the network; right "
        "of the dashed line the inverse model is faster. Naive: the same automatic differentiation on both sides; "
        "best: the fastest engine for both; automatic: DeLaN without its analytic derivatives.",
        "One row per rival and way of writing it: ratio of times on a logarithmic axis; a dashed line at one.",
        draw,
    ),
)
