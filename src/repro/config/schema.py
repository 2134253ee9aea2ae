"""The schema of a run: every key, its type and what is allowed, checked before anything is computed."""

import math
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, field_validator

from repro.config.base import Count, NotNegative, Positive, Section, Share
from repro.config.plugin_options import MODELS, OPTIMISERS, chosen
from repro.control.controller_options import CONTROLLERS, ControlOptions
from repro.control.task import Task
from repro.learning.optimiser_options import OptimiserOptions
from repro.models.options import ModelOptions


class System(Section):
    """The true system (conf/system); further keys are constants of the system, which knows their names."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, int | float]

    name: str
    damping: list[NotNegative]
    damping_frame: Literal["relative", "absolute"]
    damping_growth: NotNegative

    @property
    def constants(self) -> dict[str, int | float]:
        """The constants by name."""
        return dict(self.__pydantic_extra__)


class Reading(Section):
    """Which reading of the paper's conventions (conf/reading)."""

    name: Literal["physical", "printed"]


class RandomForce(Section):
    """Simulated data D (conf/data)."""

    source: Literal["random_force"]
    regime: Literal["episodes", "long"]
    episode_steps: Count
    samples: Annotated[int, Field(ge=10)]
    train_fraction: Share
    train_samples: Count | None
    time_step: Positive
    force_limit: Positive
    start: Literal["upright", "hanging"]
    reset: Literal["start", "random"]
    labels: Literal["exact", "differenced"]
    tau_noise: NotNegative
    qdd_noise: NotNegative
    q_noise: NotNegative
    qd_noise: NotNegative
    common: bool


class Columns(Section):
    """Names of the columns of a recording."""

    q: list[str]
    qd: list[str]
    tau: list[str]
    qdd: list[str] = Field(default_factory=list)
    time: list[str] = Field(default_factory=list)
    episode: list[str] = Field(default_factory=list)


class File(Section):
    """One's own recording (conf/data/file)."""

    source: Literal["file"]
    path: str
    columns: Columns
    time_step: Positive | None
    train_fraction: Share


class Curriculum(Section):
    """Earlier training phases on shorter episodes (conf/curriculum)."""

    episodes: list[Count]
    samples: Annotated[int, Field(ge=10)]


class Basis(Section):
    """Features of T and V (conf/basis): a file of repro/models/bases."""

    name: str


class Objective(Section):
    """The loss (conf/objective)."""

    kind: Literal["inverse", "forward", "port"]
    momentum_weight: NotNegative
    l1_kinetic: NotNegative
    l1_potential: NotNegative
    error_scale: Positive | None
    equal_weight_share: Annotated[float, Field(ge=0, le=1)]
    passivity_states: Annotated[int, Field(ge=0)]


class Sequence(Section):
    """Which data in which order (conf/sequence)."""

    kind: Literal["main", "anchored", "pretrain_only", "pretrain", "joint"]
    energy_weight: Positive
    energy_form: Literal["legendre", "sum"]
    initial_angles: Annotated[int, Field(ge=2)]
    grid: Literal["product", "diagonal"]
    steps: Annotated[int, Field(ge=1)]
    pretraining_epochs: Count | None


class Energies(Section):
    """How T and V are read off a fitted model (conf/energies)."""

    gauge: Literal["raw", "anchor", "canonical", "canonical_anchor"]
    horizons: list[Positive]


class Scale(Section):
    """How much of an experiment is run (conf/scale); None where nothing is cut."""

    name: Literal["smoke", "quick", "paper"]
    samples: Annotated[int, Field(ge=10)]
    seeds: Count
    initial_angles: Annotated[int, Field(ge=2)]
    epochs: Annotated[float, Field(gt=0, le=1)]
    iterations: Annotated[float, Field(gt=0, le=1)]
    loops: Count
    seconds: Positive | None
    links: Count | None


Model = Annotated[ModelOptions, *chosen("model", MODELS)]
Optimiser = Annotated[OptimiserOptions, *chosen("optimiser", OPTIMISERS)]
Control = Annotated[ControlOptions, *chosen("control", CONTROLLERS)]


class Config(Section):
    """One run. The options of `model`, `optimiser` and `control` are those that the module of their `kind` declares."""

    system: System
    reading: Reading
    data: Annotated[RandomForce | File, Field(discriminator="source")]
    curriculum: Curriculum
    model: Model
    basis: Basis
    objective: Objective
    optimiser: Optimiser
    sequence: Sequence
    energies: Energies
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

    @field_validator("seeds", mode="before")
    @classmethod
    def _seeds(cls, value: Any) -> Any:
        numbers = value if isinstance(value, list) else [value]
        whole = bool(numbers) and all(isinstance(n, int) and not isinstance(n, bool) and n >= 0 for n in numbers)
        if value is not None and (not whole or value == 0):
            raise ValueError("give a number of members (1 or more), a list of seeds such as [0,1,5], or null")
        if len(set(numbers)) < len(numbers):
            raise ValueError("a seed is given twice, so two members would be the same; give each once")
        return value

    @property
    def members(self) -> list[int]:
        """The seeds, one a member."""
        count = self.scale.seeds if self.seeds is None else self.seeds
        return list(range(count)) if isinstance(count, int) else list(count)


def scaled(config: Config) -> Config:
    """The same run at its scale: samples capped, epochs and iterations shortened, long motions and chains left out."""
    scale = config.scale
    share = scale.epochs if config.optimiser.unit == "epochs" else scale.iterations
    updates: dict[str, Any] = {"optimiser": config.optimiser.shortened(share)}
    horizons = _up_to(scale.seconds, config.energies.horizons)
    updates["task"] = replace(config.task, seconds=min(config.task.seconds, scale.seconds or math.inf))
    updates["energies"] = config.energies.model_copy(update={"horizons": horizons})
    updates |= {name: _up_to(scale.links, getattr(config, name)) for name in ("chain", "whole_chain")}
    if isinstance(config.data, RandomForce):
        updates["data"] = config.data.model_copy(update={"samples": min(config.data.samples, scale.samples)})
        shorter = min(config.curriculum.samples, scale.samples)
        sequence: dict[str, Any] = {"initial_angles": min(config.sequence.initial_angles, scale.initial_angles)}
        if config.sequence.pretraining_epochs is not None:
            sequence["pretraining_epochs"] = max(1, math.ceil(config.sequence.pretraining_epochs * scale.epochs))
        updates["sequence"] = config.sequence.model_copy(update=sequence)
        updates["curriculum"] = config.curriculum.model_copy(update={"samples": shorter})
    return config.model_copy(update=updates)


def _up_to(most: float | None, values: list[Any]) -> list[Any]:
    return [value for value in values if most is None or value <= most]
