"""What each kind of stage depends on beside the stages upstream: its options are all that its work is handed."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from repro.control.task import LoopPlan
from repro.data.data_options import FreeMotionOptions, RandomForce, RecordingFile
from repro.evaluation.metric_options import MetricOptions
from repro.learning.objective_options import OBJECTIVES
from repro.learning.optimiser_options import OPTIMISERS
from repro.learning.sequence_options import SEQUENCES
from repro.learning.training_options import Training
from repro.mechanics.system_options import SYSTEMS, SystemOptions
from repro.models.gauge import Gauge
from repro.models.model_options import MODELS, ModelOptions
from repro.plugins.checked import chosen, validated
from repro.plugins.options import Options
from repro.plugins.plugin import plugin_module
from repro.tracking.files import file_digest


@dataclass(frozen=True)
class DataOptions(Options):
    """Of a dataset.

    system: None for a recording that has coordinates of its own; sha256: of the files, where data are read from files.
    """

    system: SystemOptions | None
    seeds: tuple[int, ...]
    source: RandomForce | FreeMotionOptions | RecordingFile
    sha256: str = ""

    @property
    def label(self) -> str:
        """A word for a dataset."""
        source = self.source
        if isinstance(source, RecordingFile):
            return "recording"
        if isinstance(source, FreeMotionOptions):
            return "free"
        return source.regime if source.regime == "long" else f"episodes{source.episode_steps}"

    @property
    def code(self) -> list[str]:
        """The module of its system."""
        return [] if self.system is None else [plugin_module(SYSTEMS, self.system.name)]


@dataclass(frozen=True)
class FitOptions(Options):
    """Of a fitted ensemble.

    simulated: the data come from the true system, which the model may know; training: None for a model without weights;
    parts: of the trained sub-models, in order; system: None for a recording that has coordinates of its own.
    """

    system: SystemOptions | None
    seeds: tuple[int, ...]
    simulated: bool
    model: Annotated[ModelOptions, *chosen("model", MODELS)]
    basis: str
    training: Training | None
    parts: tuple["FitOptions", ...] = ()

    @property
    def code(self) -> list[str]:
        """The modules of its system, and those that build its model and the models of its parts."""
        system = [] if self.system is None else [plugin_module(SYSTEMS, self.system.name)]
        own = [*system, plugin_module(MODELS, self.model.kind), plugin_module("models.bases", self.basis)]
        return own + [module for part in self.parts for module in part.code]

    @property
    def loss_code(self) -> list[str]:
        """The modules of what is minimised."""
        if (training := self.training) is None:
            return []
        return [plugin_module(OBJECTIVES, training.objective.kind), plugin_module(SEQUENCES, training.sequence.kind)]

    @property
    def optimiser_code(self) -> list[str]:
        """The modules that minimise it."""
        if (training := self.training) is None:
            return []
        device = [] if training.device == "cpu" else [plugin_module("learning.device", "device_adam")]
        return [plugin_module(OPTIMISERS, training.optimiser.kind), *device]

    @classmethod
    def stored(cls, content: Mapping[str, Any]) -> "FitOptions":
        """Read back from a run.json; UserError where its model does not exist any more, or has other options."""
        options: FitOptions = validated(cls, "fit", content)
        return options


@dataclass(frozen=True, kw_only=True)
class LoopOptions(LoopPlan):
    """Of the closed loops with a fitted ensemble."""

    fit: FitOptions


@dataclass(frozen=True)
class RunOptions(Options):
    """Of the measurements of a fitted ensemble.

    chain, whole_chain: numbers of links of chains that are made of the model, or learned as a whole for comparison.
    metric: taken beside the usual ones.
    """

    fit: FitOptions
    gauge: Gauge
    metric: MetricOptions
    horizons: tuple[float, ...] = ()
    chain: tuple[int, ...] = ()
    whole_chain: tuple[int, ...] = ()
    tau_noise: float = 0.0


@dataclass(frozen=True)
class RecordingOptions(Options):
    """Of the recording of a run; links: of the chain that it shows, where it shows one."""

    fit: FitOptions
    title: str
    links: int | None = None


def recording_digest(source: RecordingFile) -> str:
    """SHA-256 of the files of a recording in their order, in hexadecimal; of a single file, that of its bytes."""
    from repro.data.recording_file import files_read

    files, tests = files_read(source)
    if len(files) == 1 and not tests and not source.test_episodes:
        return file_digest(files[0])
    # The names of files are names of episodes, so they matter where test episodes are chosen.
    named = [path.name if source.test_episodes else "" for path in (*files, *tests)]
    lines = [f"{file_digest(path)} {name}" for path, name in zip((*files, *tests), named, strict=True)]
    return hashlib.sha256("\n".join([*lines, str(len(tests))]).encode()).hexdigest()
