"""Every figure of the report, in the order in which it is read."""

import os
from collections.abc import Sequence
from pathlib import Path

from repro.report.figures import (
    architecture,
    closed_loop,
    composition,
    dip_energies,
    forward_inverse,
    identifiability,
    learning_curves,
    passivity,
    pretraining,
    regimes,
    sensitivity,
    success_map,
    timing,
    validation,
)
from repro.report.figures.figure import Figure
from repro.report.results import Results
from repro.tracking.jobs import Job, reason
from repro.tracking.pool import run_jobs

FIGURES: Sequence[Figure] = (
    architecture.FRAMEWORK,
    architecture.PLNN,
    validation.FIGURE,
    regimes.FIGURE,
    forward_inverse.FIGURE,
    learning_curves.OBJECTIVES,
    learning_curves.OPTIMISERS,
    identifiability.FIGURE,
    dip_energies.FIGURE,
    pretraining.ERRORS,
    pretraining.CURVES,
    architecture.MATRICES,
    passivity.MARGINS,
    passivity.ENERGY,
    composition.SAMPLES,
    composition.LENGTHS,
    closed_loop.SINGLE,
    closed_loop.DOUBLE,
    success_map.FIGURE,
    timing.FIGURE,
    sensitivity.FIGURE,
)


# What drawing needs and takes long to load.
PRELOAD = (__name__, "pandas", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf")


def draw_all(results: Results, folder: Path) -> list[Figure]:
    """Write every figure that the results can fill, as PDF and PNG, several at once; return those written."""
    jobs = [
        Job(figure.name, f"{__name__}:draw", {"number": number, "results": results, "folder": folder})
        for number, figure in enumerate(FIGURES)
    ]
    ended = run_jobs(jobs, workers=os.cpu_count() or 1, preload=PRELOAD, logs=folder.parent / "logs")
    for result in ended:
        if not result.ok:
            raise RuntimeError(f"figure {result.job.name}: {reason(result)}\n{(result.error or {}).get('trace', '')}")
    return [figure for figure, result in zip(FIGURES, ended, strict=True) if result.value]


def draw(number: int, results: Results, folder: Path) -> bool:
    """Write one of the figures; whether there was anything to show."""
    return FIGURES[number].save(results, folder)
