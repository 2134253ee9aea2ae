"""About how long a job takes: as long as stages of its name took before, else what its sizes let expect."""

import re
from collections.abc import Mapping
from functools import cached_property
from statistics import median

from repro.config.described_system import true_system
from repro.config.schema import Config
from repro.pipeline.plan import Pipeline
from repro.tracking import index
from repro.tracking.paths import Paths
from repro.tracking.stage import Stage

# Seconds on one core, measured with the examples of this project.
OVERHEAD = 3.0
SAMPLE = 5e-6  # made, stored, fitted in closed form and evaluated
SAMPLE_AND_UNIT = 1e-8  # of a network, per epoch
ITERATION = 4e-3
LOOP_SECOND = 0.015  # per second of a closed loop and square of the number of coordinates


class MeasuredTimes:
    """Median times of the finished stages of a store, by kind, name and scale; the store is read when first needed."""

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def seconds(self, stage: Stage) -> float | None:
        """The median time of the stages like this one; None where none is finished."""
        return self._medians.get((stage.kind, stage.name, _scale(stage.command)))

    @cached_property
    def _medians(self) -> Mapping[tuple[str, str, str], float]:
        times: dict[tuple[str, str, str], list[float]] = {}
        for entry in index.load(self._paths).finished().values():
            times.setdefault((entry.kind, entry.name, _scale(entry.command)), []).append(entry.wall_s)
        return {key: median(values) for key, values in times.items()}


def expected_seconds(pipeline: Pipeline, times: MeasuredTimes) -> float:
    """The expected time of the stages that can take long: the fit and the closed loops."""
    config = pipeline.config
    fit = times.seconds(pipeline.fit_stage)
    seconds = _fit_seconds(config) if fit is None else fit
    if pipeline.control_stage is not None:
        loops = times.seconds(pipeline.control_stage)
        seconds += _loop_seconds(config) if loops is None else loops
    return seconds


def _fit_seconds(config: Config) -> float:
    optimiser, members = config.optimiser, len(config.members)
    samples = getattr(config.data, "samples", 10_000)
    handled = members * samples * SAMPLE
    if not config.model.fitted:
        return 1.0 + handled
    if optimiser.unit is None:
        return OVERHEAD + handled
    if optimiser.unit == "epochs":
        units = sum(getattr(config.model, "hidden", ())) or 1
        return OVERHEAD + members * optimiser.length * samples * units * SAMPLE_AND_UNIT
    phases = 1 + len(config.curriculum.episodes)
    return OVERHEAD + members * phases * optimiser.length * ITERATION


def _loop_seconds(config: Config) -> float:
    task, coordinates = config.task, true_system(config).n_q
    loops = min(task.n_loops(len(config.members)), config.loops)
    return OVERHEAD + loops * task.seconds * coordinates**2 * LOOP_SECOND


def _scale(command: str) -> str:
    """The scale that a command line names; empty for the default."""
    match = re.search(r"\bscale=(\w+)", command)
    return match[1] if match else ""
