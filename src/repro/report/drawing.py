"""Every figure of the report, in the order in which it is read."""

import os
from collections.abc import Sequence
from pathlib import Path

from repro.launch.jobs import Job, reason
from repro.launch.pool import run_jobs
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
from repro.results.results import Results

FIGURES: Sequence[Figure] = (
    architecture.FRAMEWORK,
    architecture.PLNN,
    validation.FIGURE,
    regimes.FIGURE,
    forward_inverse.FIGURE,
    learning_curves.OBJECTIVES,
    learning_curves.INERTIAS,
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
    """Write every figure that the results can fill, as PDF and PNG, a share on each core; return those written."""
    cores = os.cpu_count() or 1
    shares = [range(first, len(FIGURES), cores) for first in range(min(cores, len(FIGURES)))]
    # The results travel once to each share: they weigh more than any figure.
    jobs = [
        Job(f"figures {number}", f"{__name__}:draw", {"numbers": share, "results": results, "folder": folder})
        for number, share in enumerate(shares, start=1)
    ]
    ended = run_jobs(jobs, workers=cores, preload=PRELOAD, logs=folder.parent / "logs")
    for result in ended:
        if not result.ok:
            raise RuntimeError(f"{result.job.name}: {reason(result)}\n{result.error.trace if result.error else ''}")
    written = {number for result in ended for number in result.value}
    return [figure for number, figure in enumerate(FIGURES) if number in written]


def draw(numbers: Sequence[int], results: Results, folder: Path) -> list[int]:
    """Write some of the figures; return those for which there was something to show."""
    return [number for number in numbers if FIGURES[number].save(results, folder)]
