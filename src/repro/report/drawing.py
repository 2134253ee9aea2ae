"""Draws every figure of the report, a share on each core."""

import gc
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from repro.claims.assumption_effects import AssumptionEffect
from repro.launch.jobs import Event, Job, reason
from repro.launch.machine import allowed_cores
from repro.launch.pool import run_jobs
from repro.report.figures.figure import Figure
from repro.report.figures.sensitivity import sensitivity_figure
from repro.report.paper import load_figures, paper_folder
from repro.results.results import Results
from repro.tracking import progress

UNUSED = 200_000  # objects made before Python looks for those that are not used any more
# What drawing needs and takes long to load.
PRELOAD = (__name__, "pandas", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf")


def draw_all(results: Results, effects: Sequence[AssumptionEffect], folder: Path) -> list[Figure]:
    """Write every figure that results and effects can fill, as PDF and PNG; return those written."""
    figures = [*load_figures(paper_folder()), sensitivity_figure(effects)]
    names = [figure.name for figure in figures]
    cores = min(allowed_cores(), len(names))
    # The results travel once to each share: they weigh more than any figure.
    given = {"results": replace(results, sensitivity=None), "effects": effects, "folder": folder}
    jobs = [Job(f"figures {n + 1}", f"{__name__}:draw", {"names": names[n::cores], **given}) for n in range(cores)]

    def shown(event: Event) -> None:
        if event.fraction is not None:
            progress.report(0.2 + 0.5 * event.fraction, f"figure {event.text}")

    ended = run_jobs(jobs, workers=cores, preload=PRELOAD, logs=folder.parent / "logs", on_progress=shown)
    for result in ended:
        if not result.ok:
            raise RuntimeError(f"{result.job.name}: {reason(result)}\n{result.trace}")
    written = {name for result in ended for name in result.value}
    return [figure for figure in figures if figure.name in written]


def draw(names: Sequence[str], results: Results, effects: Sequence[AssumptionEffect], folder: Path) -> list[str]:
    """Write some of the figures, in a process of its own; return the names of those that had something to show."""
    # Python's search for unused objects goes through all artists of a figure again and again: an eighth of the time.
    gc.freeze()
    gc.set_threshold(UNUSED)
    figures = [*load_figures(paper_folder()), sensitivity_figure(effects)]
    chosen = [figure for figure in figures if figure.name in names]
    saved = []
    for number, figure in enumerate(chosen):
        progress.report(number / len(chosen), figure.name)
        saved += [figure.name] * figure.save(results, folder)
    return saved
