"""Every figure of the report, in the order in which it is read."""

from collections.abc import Sequence
from pathlib import Path

from repro.report.figures import (
    dip_energies,
    forward_inverse,
    identifiability,
    learning_curves,
    pretraining,
    regimes,
    validation,
)
from repro.report.figures.figure import Figure
from repro.report.results import Results

FIGURES: Sequence[Figure] = (
    validation.FIGURE,
    regimes.FIGURE,
    forward_inverse.FIGURE,
    learning_curves.OBJECTIVES,
    learning_curves.OPTIMISERS,
    identifiability.FIGURE,
    dip_energies.FIGURE,
    pretraining.ERRORS,
    pretraining.CURVES,
)


def draw_all(results: Results, folder: Path) -> list[Figure]:
    """Write every figure that the results can fill, as PDF and PNG; return those written."""
    return [figure for figure in FIGURES if figure.save(results, folder)]
