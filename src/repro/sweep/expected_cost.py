"""About what a job takes, in time and memory: what stages of its name took before, else what its sizes let expect."""

import re
from collections.abc import Mapping
from functools import cached_property
from statistics import median

from repro.config.schema import Config, true_system
from repro.models.model_options import ModelOptions
from repro.pipeline.plan import Pipeline
from repro.tracking import index
from repro.tracking.index import Entry
from repro.tracking.paths import Paths
from repro.tracking.stage import Stage

# Seconds on one core, measured with the examples of this project.
OVERHEAD = 3.0
SAMPLE = 5e-6  # made, stored, fitted in closed form and evaluated
SAMPLE_AND_UNIT = 1e-8  # of a network, per epoch
ITERATION = 4e-3
LOOP_SECOND = 0.015  # per second of a closed loop and square of the number of coordinates

LIBRARIES_MIB = 400.0
BYTES_A_SAMPLE = 150  # and coordinate, of one seed
BYTES_A_UNIT = 1_000_000  # of the widest layer, with its derivatives at a block of samples


class MeasuredStages:
    """Time and memory of the finished stages of a store, by kind, name and scale; it is read when first needed."""

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def like(self, stage: Stage) -> list[Entry]:
        """The finished stages like this one."""
        return self._entries.get(_key(stage), [])

    @cached_property
    def _entries(self) -> Mapping[tuple[str, str, str], list[Entry]]:
        entries: dict[tuple[str, str, str], list[Entry]] = {}
        for entry in index.load(self._paths).finished().values():
            entries.setdefault(_key(entry), []).append(entry)
        return entries


def expected_mib(pipeline: Pipeline, measured: MeasuredStages) -> float:
    """The expected peak of the process that makes all stages of a run, in MiB."""
    if known := measured.like(pipeline.run_stage):
        return max(entry.peak_memory_mib for entry in known)
    config = pipeline.config
    samples = getattr(config.data, "samples", 10_000)
    if config.sequence.uses_free_motion:
        samples += config.sequence.initial_angles**2 * config.sequence.steps
    coordinates = true_system(config).n_q
    widest = max(_hidden(config.model), default=0)
    return (
        LIBRARIES_MIB + (len(config.members) * samples * coordinates * BYTES_A_SAMPLE + widest * BYTES_A_UNIT) / 1024**2
    )


def expected_seconds(pipeline: Pipeline, measured: MeasuredStages) -> float:
    """The expected time of the stages that can take long: the fit and the closed loops."""
    config = pipeline.config
    fits = [entry.wall_s for entry in measured.like(pipeline.fit_stage)]
    seconds = median(fits) if fits else _fit_seconds(config)
    if pipeline.control_stage is None:
        return seconds
    loops = [entry.wall_s for entry in measured.like(pipeline.control_stage)]
    return seconds + (median(loops) if loops else _loop_seconds(config))


def _fit_seconds(config: Config) -> float:
    optimiser, members = config.optimiser, len(config.members)
    samples = getattr(config.data, "samples", 10_000)
    handled = members * samples * SAMPLE
    if not config.model.fitted:
        return 1.0 + handled
    if (budget := getattr(optimiser, "budget_s", None)) is not None:
        return OVERHEAD + members * float(budget)
    if optimiser.unit is None:
        return OVERHEAD + handled
    if optimiser.unit == "epochs":
        units = sum(_hidden(config.model)) or 1
        return OVERHEAD + members * optimiser.length * samples * units * SAMPLE_AND_UNIT
    phases = 1 + len(config.curriculum.episodes)
    return OVERHEAD + members * phases * optimiser.length * ITERATION


def _loop_seconds(config: Config) -> float:
    task, coordinates = config.task, true_system(config).n_q
    loops = min(task.n_loops(len(config.members)), config.loops)
    return OVERHEAD + loops * task.seconds * coordinates**2 * LOOP_SECOND


def _key(stage: Stage | Entry) -> tuple[str, str, str]:
    """Kind, name, and the scale that the command line names; empty for the default."""
    match = re.search(r"\bscale=(\w+)", stage.command)
    return stage.kind, stage.name, match[1] if match else ""


def _hidden(model: ModelOptions) -> tuple[int, ...]:
    """Units of each hidden layer; a model of the user may name them otherwise, or give a single number."""
    hidden = getattr(model, "hidden", ())
    return hidden if isinstance(hidden, tuple) else ()
