"""Every figure of the report, in the order in which it is read."""

from collections.abc import Sequence
from pathlib import Path

from repro.report.figures import forward_inverse, learning_curves, regimes, validation
from repro.report.figures.figure import Figure
from repro.report.results import Results

FIGURES: Sequence[Figure] = (
    validation.FIGURE,
    regimes.FIGURE,
    forward_inverse.FIGURE,
    learning_curves.OBJECTIVES,
    learning_curves.OPTIMISERS,
)


def draw_all(results: Results, folder: Path) -> list[Figure]:
    """Write every figure that the results can fill, as PDF and PNG; return those written."""
    return [figure for figure in FIGURES if figure.save(results, folder)]
