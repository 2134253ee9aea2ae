"""The schema of a run: every key, its type and what is allowed, checked before anything is computed."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from repro.control.controller import CONTROLLERS, ControlOptions
from repro.control.task import Task
from repro.data.data_options import DataSource, RandomForce, RecordingFile
from repro.evaluation.metric_options import METRICS, MetricOptions
from repro.learning.objective_options import OBJECTIVES, ObjectiveOptions
from repro.learning.optimiser_options import OPTIMISERS, OptimiserOptions
from repro.learning.sequence_options import SEQUENCES, SequenceOptions
from repro.mechanics.system_options import Reading, SystemOptions
from repro.models.gauge import Gauge
from repro.models.model_options import MODELS, ModelOptions
from repro.plugins.checked import chosen
from repro.plugins.options import Count, NotNegative, Positive

if TYPE_CHECKING:
    from repro.mechanics.coordinate import Coordinate
    from repro.mechanics.system import System

LARGEST_SEED = 2**32  # what the generators of all libraries take


class Section(BaseModel):
    """A group of keys; a key that is not listed is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class SystemSection(Section):
    """The true system (conf/system); further keys are constants that the system declares."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)
    __pydantic_extra__: dict[str, int | float]

    name: str
    damping: list[NotNegative]
    coulomb: list[NotNegative] = Field(default_factory=list)
    damping_frame: Literal["relative", "absolute"] = "relative"
    damping_growth: NotNegative = 0.0


class ReadingSection(Section):
    """Which reading of the paper's conventions (conf/reading)."""

    name: Reading


class Curriculum(Section):
    """Earlier training phases on shorter episodes (conf/curriculum)."""

    episodes: list[Count]
    samples: Annotated[int, Field(ge=10)]


class Basis(Section):
    """Features of T and V (conf/basis): a file of repro/models/bases."""

    name: str


class Energies(Section):
    """How T and V are read off a fitted model (conf/energies)."""

    gauge: Gauge
    horizons: list[Positive]


class Scale(Section):
    """How much of an experiment is run (conf/scale); None where nothing is cut."""

    name: Literal["smoke", "quick", "paper"]
    samples: Annotated[int, Field(ge=10)]
    seeds: Count
    most_seeds: Count | None
    initial_angles: Annotated[int, Field(ge=2)]
    epochs: Annotated[float, Field(gt=0, le=1)]
    iterations: Annotated[float, Field(gt=0, le=1)]
    loops: Count
    seconds: Positive | None
    links: Count | None


Model = Annotated[ModelOptions, *chosen("model", MODELS)]
Objective = Annotated[ObjectiveOptions, *chosen("objective", OBJECTIVES)]
Sequence = Annotated[SequenceOptions, *chosen("sequence", SEQUENCES)]
Optimiser = Annotated[OptimiserOptions, *chosen("optimiser", OPTIMISERS)]
Metric = Annotated[MetricOptions, *chosen("metric", METRICS)]
Control = Annotated[ControlOptions, *chosen("control", CONTROLLERS)]


class Config(Section):
    """One run. Groups with a `kind` have the options that the module of this name declares."""

    system: SystemSection
    reading: ReadingSection
    data: Annotated[DataSource, Field(discriminator="source")]
    curriculum: Curriculum
    model: Model
    basis: Basis
    objective: Objective
    optimiser: Optimiser
    sequence: Sequence
    energies: Energies
    metric: Metric
    control: Control
    task: Task
    scale: Scale
    seeds: int | list[int] | None
    device: Literal["cpu", "cuda"]
    record: bool
    chain: list[Count]
    whole_chain: list[Count]
    experiment: str | None
    sweep: list[str]
    explicit: list[str]  # keys that the command line gives, which the scale does not cut

    @field_validator("seeds", mode="before")
    @classmethod
    def _seeds(cls, value: Any) -> Any:
        numbers = value if isinstance(value, list) else [value]
        whole = bool(numbers) and all(isinstance(n, int) and not isinstance(n, bool) and n >= 0 for n in numbers)
        if value is not None and (not whole or value == 0):
            raise ValueError(
                "give a number of members (1 or more), a list of seeds such as [0,1,5], or null; "
                "for a job per seed write seeds=[0],[1],..."
            )
        if value is not None and max(numbers) >= LARGEST_SEED:
            raise ValueError(f"a seed, and a number of members, is below 2**32 = {LARGEST_SEED}")
        if len(set(numbers)) < len(numbers):
            raise ValueError("a seed is given twice, so two members would be the same; give each once")
        return value

    def cuts(self, key: str) -> bool:
        """Whether the scale may cut the value of a key: the command line does not give it."""
        return key not in self.explicit

    @property
    def loops(self) -> int:
        """Closed loops of a run, at most."""
        given = not (self.cuts("task.initial_states") and self.cuts("task.x_des"))
        return self.task.n_loops(len(self.members)) if given else self.scale.loops

    @property
    def system_options(self) -> SystemOptions:
        """The true system, in a reading of the paper's conventions."""
        system = self.system
        damping, coulomb = tuple(system.damping), tuple(system.coulomb)
        return SystemOptions(
            system.name, self.reading.name, damping, system.damping_frame, system.damping_growth, coulomb,
            dict(system.__pydantic_extra__),
        )  # fmt: skip

    @property
    def own_coordinates(self) -> bool:
        """Whether the data are a recording with coordinates of its own, so that `system` plays no part."""
        return isinstance(self.data, RecordingFile) and bool(self.data.coordinates.names)

    @property
    def members(self) -> list[int]:
        """The seeds, one per member."""
        count = self.scale.seeds if self.seeds is None else self.seeds
        chosen = list(range(count)) if isinstance(count, int) else list(count)
        return chosen[: self.scale.most_seeds] if self.cuts("seeds") else chosen


def coordinates_of(config: Config) -> "tuple[Coordinate, ...]":
    """The coordinates of the data: those of a recording that names them, else those of the system."""
    if isinstance(config.data, RecordingFile) and config.own_coordinates:
        return config.data.coordinates.described()
    return true_system(config).coordinates


def true_system(config: Config) -> "System":
    """The system that the configuration describes; UserError for constants that it cannot have."""
    from repro.mechanics.system import load_system

    return load_system(config.system_options)


def scaled(config: Config) -> Config:
    """The same run at its scale: samples capped, epochs and iterations shortened, long motions and chains left out.

    What the command line gives explicitly stays as it is.
    """
    scale, cut = config.scale, config.optimiser.cut_by
    updates: dict[str, Any] = {}
    if config.cuts(f"optimiser.{cut}"):
        updates["optimiser"] = config.optimiser.shortened(scale.iterations if cut == "iterations" else scale.epochs)
    if config.cuts("task.seconds"):
        updates["task"] = replace(config.task, seconds=min(config.task.seconds, scale.seconds or math.inf))
    if config.cuts("energies.horizons"):
        horizons = _up_to(scale.seconds, config.energies.horizons)
        updates["energies"] = config.energies.model_copy(update={"horizons": horizons})
    updates |= {
        name: _up_to(scale.links, getattr(config, name)) for name in ("chain", "whole_chain") if config.cuts(name)
    }
    if isinstance(config.data, RandomForce):
        sequence, epochs = config.sequence, config.sequence.pretraining_epochs
        if epochs is not None and config.cuts("sequence.pretraining_epochs"):
            sequence = replace(sequence, pretraining_epochs=max(1, math.ceil(epochs * scale.epochs)))
        if config.cuts("sequence.initial_angles"):
            sequence = replace(sequence, initial_angles=min(sequence.initial_angles, scale.initial_angles))
        updates["sequence"] = sequence
        if config.cuts("data.samples"):
            updates["data"] = replace(config.data, samples=min(config.data.samples, scale.samples))
        if config.cuts("curriculum.samples"):
            samples = min(config.curriculum.samples, scale.samples)
            updates["curriculum"] = config.curriculum.model_copy(update={"samples": samples})
    return config.model_copy(update=updates)


def _up_to(most: float | None, values: list[Any]) -> list[Any]:
    return [value for value in values if most is None or value <= most]
