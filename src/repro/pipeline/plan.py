"""What one run consists of: its stages in their order, each with its options, the stages upstream, and its code."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from repro.config.rules import linear
from repro.config.schema import Config, scaled
from repro.config.submodels import fit_of, is_settings, settings_of
from repro.control.controller import CONTROLLERS, ControllerOptions
from repro.data.data_options import DataSource, FreeMotionOptions, RandomForce, RecordingFile
from repro.errors import UserError
from repro.evaluation.metric_options import METRICS
from repro.learning.training_options import Training
from repro.mechanics.system_options import SystemOptions
from repro.pipeline.stage_options import (
    DataOptions,
    FitOptions,
    LoopOptions,
    RecordingOptions,
    RunOptions,
    recording_digest,
)
from repro.plugins.options import Options
from repro.plugins.plugin import plugin_module
from repro.tracking.record import Record
from repro.tracking.stage import Stage
from repro.tracking.store import Store

PRETRAINING = "pretraining"  # the role of a fit of D_H alone, upstream of the fits that begin with it
UNUSED_BASIS = "raw"  # of models without weights, which have no features
LONGEST_SHOWN = 30  # links of a chain in a recording: more are only dots


@dataclass(frozen=True)
class Pipeline:
    """The stages of one run. Their ids follow from configuration and code alone, without computing anything."""

    config: Config  # at its scale
    command: str

    @classmethod
    def of(cls, config: Config, command: str) -> "Pipeline":
        """The pipeline of a configuration at its scale."""
        return cls(scaled(config), command)

    @cached_property
    def data_stages(self) -> dict[str, Stage]:
        """Every dataset by its role: data; stage_1, stage_2, ... of the curriculum, in front of it; free (D_H)."""
        config, sequence = self.config, self.config.sequence
        sources: dict[str, DataSource | FreeMotionOptions] = {}
        if isinstance(config.data, RandomForce):
            for number, steps in enumerate(config.curriculum.episodes, start=1):
                samples = config.curriculum.samples
                sources[f"stage_{number}"] = replace(
                    config.data, regime="episodes", episode_steps=steps, samples=samples
                )
        sources["data"] = config.data
        if sequence.uses_free_motion and config.model.fitted:
            step = config.data.time_step if isinstance(config.data, RandomForce) else FreeMotionOptions.time_step
            sources["free"] = FreeMotionOptions(
                initial_angles=sequence.initial_angles, grid=sequence.grid, steps=sequence.steps, time_step=step
            )
        return {role: self._data_stage(source) for role, source in sources.items()}

    def _data_stage(self, source: DataSource | FreeMotionOptions) -> Stage:
        sha256 = ""
        if isinstance(source, RecordingFile):
            sha256 = recording_digest(source)
        elif isinstance(source, RandomForce) and source.regime == "long":
            source = replace(source, episode_steps=RandomForce.episode_steps)  # has no effect
        options = DataOptions(self._system, tuple(self.config.members), source, sha256)
        return self._stage("data", f"{self._mechanism}-{options.label}", options, {}, "data", options.code)

    @cached_property
    def fit_options(self) -> FitOptions:
        """What the ensemble depends on."""
        config = self.config
        parts = tuple(options for options, _ in self.parts)
        simulated = isinstance(config.data, RandomForce)
        seeds, system = tuple(config.members), self._system
        if not config.model.fitted:
            return FitOptions(system, seeds, simulated, config.model, UNUSED_BASIS, None, parts)
        optimiser = replace(config.optimiser, name="")
        training = Training(config.objective, config.sequence.effective, optimiser, config.device)
        return FitOptions(system, seeds, simulated, config.model, config.basis.name, training, parts)

    @cached_property
    def fit_stage(self) -> Stage:
        """The ensemble."""
        stages = dict(self.data_stages)
        if self.pretraining_stage is not None:
            stages[PRETRAINING] = self.pretraining_stage
        return self._fit_stage(self._name(self.config.sequence.kind), self.fit_options, stages)

    @cached_property
    def pretraining_options(self) -> FitOptions | None:
        """What the first phase of the fit depends on, where that is D_H alone; otherwise None."""
        training = self.fit_options.training
        if training is None or (sequence := training.sequence.beginning) is None:
            return None
        epochs = training.sequence.pretraining_epochs
        optimiser = training.optimiser if epochs is None else training.optimiser.lasting(epochs)
        return replace(self.fit_options, training=replace(training, sequence=sequence, optimiser=optimiser))

    @cached_property
    def pretraining_stage(self) -> Stage | None:
        """The ensemble after D_H alone, which all fits that begin with it share; None for others.

        D is upstream only of models that are built by its spread, and of networks: of a few coefficients alone the
        weights are kept at every point of the learning curves, at which each fit then evaluates its own watches.
        """
        options = self.pretraining_options
        if options is None:
            return None
        alone = linear(self.config) and not self.config.model.reads_spread
        data = {role: stage for role, stage in self.data_stages.items() if role == "free" or not alone}
        return self._fit_stage(self._name("D_H"), options, data)

    def _fit_stage(self, name: str, fit: FitOptions, stages: Mapping[str, Stage]) -> Stage:
        upstream = {role: stage.id for role, stage in stages.items()}
        upstream |= {f"part_{number}": id for number, (_, id) in enumerate(self.parts, start=1)}
        return self._stage("fits", name, fit, upstream, "fit", [*fit.code, *fit.loss_code, *fit.optimiser_code])

    @cached_property
    def part_pipelines(self) -> list["Pipeline"]:
        """The pipelines of the sub-models that the model is made of, where their settings are given."""
        parts = [part for part in self.config.model.sub_models if is_settings(part)]
        return [Pipeline.of(settings_of(part, self.config), self.command) for part in parts]

    @cached_property
    def parts(self) -> list[tuple[FitOptions, str]]:
        """Options and id of the fit of every sub-model, in order."""
        planned = iter(self.part_pipelines)
        parts = []
        for part in self.config.model.sub_models:
            if is_settings(part):
                pipeline = next(planned)
                parts.append((pipeline.fit_options, pipeline.fit_stage.id))
            else:
                fit = fit_of(part)
                options = FitOptions.stored(fit.identity.config)
                if missing := [seed for seed in self.config.members if seed not in options.seeds]:
                    raise UserError(f"model.parts: {fit.id} has the seeds {list(options.seeds)}, and not {missing}")
                parts.append((options, fit.id))
        return parts

    @cached_property
    def run_stage(self) -> Stage:
        """The measurements: what is called a run."""
        config, fit = self.config, self.fit_options
        noise = config.data.tau_noise if config.whole_chain and isinstance(config.data, RandomForce) else 0.0
        chains = tuple(config.chain), tuple(config.whole_chain)
        options = RunOptions(fit, config.energies.gauge, config.metric, tuple(config.energies.horizons), *chains, noise)
        roles = [role for role in ("data", "free") if role in self.data_stages]
        upstream = {role: self.data_stages[role].id for role in roles} | {"fit": self.fit_stage.id}
        if self.control_stage is not None:
            upstream["control"] = self.control_stage.id
        code = [*fit.code, *fit.loss_code, plugin_module(METRICS, config.metric.kind)]
        code += [plugin_module("evaluation", "chains")] if config.chain else []
        code += [plugin_module("evaluation", "whole_chain")] if config.whole_chain else []
        return self._stage("runs", self.name, options, upstream, "evaluate", code)

    @cached_property
    def control_stage(self) -> Stage | None:
        """The closed loops on the true plant, where a controller is chosen."""
        config, fit = self.config, self.fit_options
        if not isinstance(config.control, ControllerOptions):
            return None
        canonical = config.energies.gauge.startswith("canonical")
        options = LoopOptions(
            fit=fit, controller=config.control, task=config.task, loops=config.loops, canonical=canonical
        )
        upstream = {"data": self.data_stages["data"].id, "fit": self.fit_stage.id}
        code = [plugin_module(CONTROLLERS, config.control.kind), *fit.code]
        return self._stage("control", self.name, options, upstream, "close_loops", code)

    @cached_property
    def recording_stage(self) -> Stage:
        """The rerun recording of the run: of a closed loop, of a chain, or of motions."""
        links = max((links for links in self.config.chain if links <= LONGEST_SHOWN), default=None)
        shown = "record_loop" if self.control_stage else "record_run" if links is None else "record_chain"
        options = RecordingOptions(self.fit_options, self.name.replace("-", " "), links)
        return self._stage("recordings", self.name, options, {"run": self.run_stage.id}, shown, options.fit.code)

    @property
    def name(self) -> str:
        """A readable name: what sets this run apart."""
        control, model = self.config.control, self._name(self.config.sequence.kind)
        return f"{model}-{control.name}" if isinstance(control, ControllerOptions) else model

    def _name(self, sequence: str) -> str:
        """What sets its model apart, after this sequence."""
        config = self.config
        words = [self._mechanism, config.model.kind]
        if config.model.fitted:
            if config.model.has_coefficients:
                words.append(config.basis.name)
            words += [config.objective.kind, config.optimiser.name]
            if config.sequence.needs_energies:
                words.append(sequence)
        return "-".join(words)

    @property
    def stages(self) -> list[Stage]:
        """All that a run consists of, in their order, the run itself last; its recording comes after it."""
        closed = [] if self.control_stage is None else [self.control_stage]
        begun = [] if self.pretraining_stage is None else [self.pretraining_stage]
        return [*self.data_stages.values(), *begun, self.fit_stage, *closed, self.run_stage]

    def finished(self, store: Store) -> Record | None:
        """The stored run, when everything that this run leaves exists: the stages that it was made from too."""
        run = store.find(self.run_stage.id, kind="runs")
        if run is None or not all(store.has(stage.id, stage.kind) for stage in self.stages):
            return None
        if self.is_recorded(run) and store.find(self.recording_stage.id, kind="recordings") is None:
            return None
        return run

    def is_recorded(self, run: Record) -> bool:
        """Whether a recording is chosen, and has motion and energy to show: a simulated model of a known system."""
        config = self.config
        if self.control_stage is not None:
            return config.record
        shows = config.model.fitted and config.model.energetic and isinstance(config.data, RandomForce)
        return config.record and shows and bool(run.summary.get("simulated"))

    @property
    def _system(self) -> SystemOptions | None:
        """The true system; None for a recording that has coordinates of its own."""
        return None if self.config.own_coordinates else self.config.system_options

    @property
    def _mechanism(self) -> str:
        return "own" if self.config.own_coordinates else self.config.system.name

    def _stage(
        self, kind: str, name: str, options: Options, upstream: Mapping[str, str], stage: str, code: Sequence[str]
    ) -> Stage:
        work = plugin_module("pipeline.stages", stage)
        return Stage(kind, name, options, dict(upstream), (work, *dict.fromkeys(code)), self.command)
