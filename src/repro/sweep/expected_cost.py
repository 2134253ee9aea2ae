"""About what a job takes, in time and memory: what the stages most like its own took, else what its sizes suggest."""

import math
import re
from collections.abc import Collection, Mapping
from functools import cached_property
from statistics import median

import numpy as np

from repro.config.schema import Config, coordinates_of, true_system
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import load_system
from repro.models.context import Context, SubModel
from repro.models.model import Model
from repro.models.model_options import MODELS, ModelOptions
from repro.pipeline.plan import Pipeline
from repro.pipeline.stage_options import FitOptions
from repro.plugins.plugin import plugin
from repro.tracking import index
from repro.tracking.index import Entry
from repro.tracking.paths import Paths
from repro.tracking.stage import Stage

# Seconds on one core, measured with the examples of this project.
OVERHEAD = 3.0
SAMPLE = 5e-6  # made, stored and evaluated
SAMPLE_AND_PAIR = 5e-8  # of coefficients, of a closed form
SAMPLE_OF_EPOCH = 2e-8
SAMPLE_AND_WEIGHT = 1e-9  # of a gradient
ROW_AND_PAIR = 5e-11  # of weights, of the normal equations of an iteration
UNCOMPILED = 3.0  # times as long above COMPILED weights
COMPILED = 400
ITERATION = 1e-3
LOOP_SECOND = 0.015  # per second of a closed loop and square of the number of coordinates
SAMPLES_OF_BUILD = 100
LEAST = 0.1  # of what the sizes suggest: a stage that was resumed took little in its last attempt

LIBRARIES_MIB = 400.0
BYTES_A_SAMPLE = 150  # and coordinate, of one seed
BYTES_A_UNIT = 1_000_000  # of the widest layer, with its derivatives at a block of samples


class MeasuredStages:
    """Time and memory of the finished stages of a store, by kind, name and scale; it is read when first needed."""

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def like(self, stage: Stage) -> list[Entry]:
        """The finished stages of its name and scale."""
        return self._entries.get(_key(stage), [])

    def seconds(self, stage: Stage, sized: float) -> float:
        """The median time of those whose commands share most words with its own; by its sizes where there is none."""
        words = {*stage.command.split()}
        apart = {entry.id: len(words ^ {*entry.command.split()}) for entry in self.like(stage)}
        closest = [entry.wall_s for entry in self.like(stage) if apart[entry.id] == min(apart.values())]
        return max(median(closest), LEAST * sized) if closest else sized

    @property
    def ids(self) -> set[str]:
        """Of all finished stages."""
        return {entry.id for entries in self._entries.values() for entry in entries}

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


def expected_seconds(pipeline: Pipeline, measured: MeasuredStages, made: Collection[str] = ()) -> float:
    """The expected time of the stages that can take long, fits and closed loops, but for those of the ids `made`."""
    sized = [(pipeline.pretraining_stage, _pretraining_seconds), (pipeline.fit_stage, _fit_seconds)]
    stages = [*sized, (pipeline.control_stage, _loop_seconds)]
    return sum(measured.seconds(stage, size(pipeline)) for stage, size in stages if stage and stage.id not in made)


def _pretraining_seconds(pipeline: Pipeline) -> float:
    options = pipeline.pretraining_options
    assert options is not None
    return OVERHEAD + _training_seconds(pipeline, options, 0, _free_samples(pipeline.config))


def _fit_seconds(pipeline: Pipeline) -> float:
    config = pipeline.config
    samples = getattr(config.data, "samples", 10_000)
    handled = len(config.members) * samples * SAMPLE
    if not config.model.fitted:
        return 1.0 + handled
    phases = 1 + len(config.curriculum.episodes)
    forced = phases * min(samples, getattr(config.data, "train_samples", None) or samples)
    beside = config.sequence.uses_free_motion and pipeline.pretraining_stage is None
    seconds = _training_seconds(pipeline, pipeline.fit_options, forced, _free_samples(config) if beside else 0)
    return OVERHEAD + handled + (seconds if config.sequence.ends_on_data else 0.0)


def _training_seconds(pipeline: Pipeline, options: FitOptions, forced: int, free: int) -> float:
    """Of all members, on so many samples of D and of D_H."""
    training, coordinates, members = options.training, coordinates_of(pipeline.config), len(options.seeds)
    assert training is not None
    optimiser, n_q = training.optimiser, len(coordinates)
    model = _model(options, coordinates)
    weights = model.n_parameters - len(range(model.n_parameters)[model.fixed])
    if (budget := getattr(optimiser, "budget_s", None)) is not None:
        return members * float(budget)
    if optimiser.unit is None:
        return members * (forced + free) * weights**2 * SAMPLE_AND_PAIR
    gradient = SAMPLE_OF_EPOCH + weights * SAMPLE_AND_WEIGHT * (1 + n_q * training.objective.needs_mass)
    if optimiser.unit == "epochs":
        return members * optimiser.length * (forced + free) * gradient
    samples = min(forced or free, getattr(optimiser, "samples", None) or math.inf) + (free if forced else 0)
    iteration = ITERATION + samples * gradient
    if optimiser.linearises:
        rows = samples * n_q * (1 + training.objective.needs_port_form)
        iteration += rows * weights**2 * ROW_AND_PAIR * (UNCOMPILED if weights > COMPILED else 1.0)
    return members * optimiser.evaluations * iteration


def _free_samples(config: Config) -> int:
    sequence, n_q = config.sequence, true_system(config).n_q
    starts: int = sequence.initial_angles ** (n_q - 1 if sequence.grid == "product" else 1)
    return starts * sequence.steps


def _model(options: FitOptions, coordinates: tuple[Coordinate, ...]) -> Model:
    """The model as it is built for some data in these coordinates."""
    parts = []
    for part in options.parts:
        model = _model(part, coordinates if part.system is None else load_system(part.system).coordinates)
        parts.append(SubModel(model, model.initial([np.random.default_rng(seed) for seed in options.seeds])))
    q = np.random.default_rng(0).normal(size=(1, SAMPLES_OF_BUILD, len(coordinates)))
    system = load_system(options.system) if options.simulated and options.system is not None else None
    context = Context(plugin("models.bases", options.basis), coordinates, q, q, q, system, tuple(parts))
    built: Model = plugin(MODELS, options.model.kind).build(context, options.model)
    return built


def _loop_seconds(pipeline: Pipeline) -> float:
    config, task = pipeline.config, pipeline.config.task
    loops = min(task.n_loops(len(config.members)), config.loops)
    return OVERHEAD + loops * task.seconds * true_system(config).n_q ** 2 * LOOP_SECOND


def _key(stage: Stage | Entry) -> tuple[str, str, str]:
    """Kind, name, and the scale that the command line names; empty for the default."""
    match = re.search(r"\bscale=(\w+)", stage.command)
    return stage.kind, stage.name, match[1] if match else ""


def _hidden(model: ModelOptions) -> tuple[int, ...]:
    """Units of each hidden layer; a model of the user may name them otherwise, or give a single number."""
    hidden = getattr(model, "hidden", ())
    return hidden if isinstance(hidden, tuple) else ()
