"""One run from its configuration: the only place that knows the order of the stages."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from repro.config.rules import FREE_MOTION
from repro.config.schema import Config, File, RandomForce, scaled
from repro.control.controller_options import CONTROLLERS, ControllerOptions
from repro.pipeline.submodels import fit_of, is_settings, model_modules, settings_of
from repro.plugins.plugin import plugin_module
from repro.tracking.record import Record
from repro.tracking.stage import Stage
from repro.tracking.store import Store

LONGEST_SHOWN = 30  # links of a chain in a recording: more are only dots


@dataclass(frozen=True)
class Pipeline:
    """The stages of one run. Their ids follow from configuration and code alone; asking for them computes nothing."""

    config: Config  # at its scale
    command: str

    @classmethod
    def of(cls, config: Config, command: str) -> "Pipeline":
        """The pipeline of a configuration at its scale."""
        return cls(scaled(config), command)

    @cached_property
    def data_stages(self) -> dict[str, Stage]:
        """Every dataset by its role: data, stage 1, stage 2, ... of the curriculum, and free (D_H)."""
        config = self.config
        stages = {}
        if isinstance(config.data, RandomForce):
            for number, steps in enumerate(config.curriculum.episodes, start=1):
                shorter = {"regime": "episodes", "episode_steps": steps, "samples": config.curriculum.samples}
                stages[f"stage_{number}"] = self._data_stage(config.data.model_copy(update=shorter))
        stages["data"] = self._data_stage(config.data)
        if config.sequence.kind in FREE_MOTION and not self._without_fit:
            free = config.sequence.model_dump(include={"initial_angles", "grid", "steps"}) | {
                "time_step": _time_step(config)
            }
            stages["free"] = self._stage(
                "data",
                f"{config.system.name}-free",
                {"source": "free_motion", **free},
                {},
                ("repro.pipeline.stages.data", self._system_module),
            )
        return stages

    @cached_property
    def fit_stage(self) -> Stage:
        """The ensemble."""
        config = self.config
        parts: dict[str, Any] = {"model": config.model.plain(), "basis": config.basis.name}
        modules = ["repro.pipeline.stages.fit", self._model_module, plugin_module("models.bases", config.basis.name)]
        if self._without_fit:
            parts.pop("basis")
            modules.pop()
        else:
            settings = {key: value for key, value in config.optimiser.plain().items() if key != "name"}
            parts |= {
                "objective": config.objective.model_dump(),
                "optimiser": settings,
                "sequence": config.sequence.model_dump() if config.sequence.kind != "main" else {"kind": "main"},
            }
            modules.append(plugin_module("learning.optimisers", config.optimiser.kind))
            if config.device != "cpu":
                parts["device"] = config.device
                modules.append("repro.learning.device.device_adam")
        upstream = {role: stage.id for role, stage in self.data_stages.items()}
        for number, (fit, of_model) in enumerate(self._part_fits, start=1):
            upstream[f"part_{number}"] = fit
            modules += of_model
        return self._stage("fits", self.model_name, parts, upstream, (*modules, self._system_module))

    @cached_property
    def part_pipelines(self) -> list["Pipeline"]:
        """The pipelines of the sub-models that the model is made of, where their settings are given."""
        return [Pipeline.of(settings_of(part, self.config), self.command) for part in self._parts if is_settings(part)]

    @property
    def _parts(self) -> list[str]:
        return list(self.config.model.sub_models)

    @property
    def _part_fits(self) -> Iterator[tuple[str, list[str]]]:
        """The id of the fit of every sub-model, in order, and the modules of its model."""
        made = iter(self.part_pipelines)
        for part in self._parts:
            if is_settings(part):
                stage = next(made).fit_stage
                yield stage.id, [name for name in stage.modules if name.startswith("repro.models.")]
            else:
                fit = fit_of(part)
                yield fit.id, model_modules(fit)

    @cached_property
    def run_stage(self) -> Stage:
        """The evaluation: what is called a run."""
        roles = [role for role in ("data", "free") if role in self.data_stages]
        upstream = {role: self.data_stages[role].id for role in roles} | {"fit": self.fit_stage.id}
        parts: dict[str, Any] = {"reading": self.config.energies.gauge}
        if self.config.energies.horizons:
            parts["horizons"] = self.config.energies.horizons
        if self.config.chain:
            parts["chain"] = self.config.chain
        if self.config.whole_chain:
            parts["whole_chain"] = self.config.whole_chain
        if self.control_stage is not None:
            upstream["control"] = self.control_stage.id
        stages = ("repro.pipeline.stages.evaluate", "repro.pipeline.stages.examine")
        modules = [*stages, self._model_module, self._system_module]
        if self.config.chain:
            modules.append("repro.evaluation.chains")
        if self.config.whole_chain:
            modules.append("repro.evaluation.whole_chain")
        return self._stage("runs", self.name, parts, upstream, modules)

    @cached_property
    def control_stage(self) -> Stage | None:
        """The closed loops on the true plant, where a controller is chosen."""
        config = self.config
        if not isinstance(config.control, ControllerOptions):
            return None
        parts = {
            "control": config.control.plain(),
            "task": config.task.plain(),
            "loops": config.scale.loops,
            "canonical": config.energies.gauge.startswith("canonical"),
        }
        upstream = {"data": self.data_stages["data"].id, "fit": self.fit_stage.id}
        controller = plugin_module(CONTROLLERS, config.control.kind)
        modules = ("repro.pipeline.stages.close_loops", controller, self._model_module, self._system_module)
        return self._stage("control", self.name, parts, upstream, modules)

    @cached_property
    def recording_stage(self) -> Stage:
        """The rerun recording of the run."""
        if self.control_stage is not None:
            module = "repro.pipeline.stages.record_loop"
        else:
            module = (
                "repro.pipeline.stages.record_run"
                if self.recorded_chain is None
                else "repro.pipeline.stages.record_chain"
            )
        return self._stage("recordings", self.name, {}, {"run": self.run_stage.id}, (module, self._system_module))

    @property
    def recorded_chain(self) -> int | None:
        """The number of links of the chain that the recording shows, if any."""
        return max((links for links in self.config.chain if links <= LONGEST_SHOWN), default=None)

    @property
    def name(self) -> str:
        """A readable name: what sets this run apart."""
        driven = [] if self.config.control.kind == "none" else [self.config.control.name]
        return "-".join([self.model_name, *driven])

    @property
    def model_name(self) -> str:
        """What sets its model apart."""
        config = self.config
        words = [config.system.name, config.model.kind]
        if not self._without_fit:
            if config.model.has_coefficients:
                words.append(config.basis.name)
            words += [config.objective.kind, config.optimiser.name]
            if config.sequence.kind != "main":
                words.append(config.sequence.kind)
        return "-".join(words)

    @property
    def stages(self) -> list[Stage]:
        """All that a run consists of, in their order, the run itself last; its recording comes after it."""
        closed = [] if self.control_stage is None else [self.control_stage]
        return [*self.data_stages.values(), self.fit_stage, *closed, self.run_stage]

    def finished(self, store: Store) -> Record | None:
        """The stored run, when all that this run should leave is there."""
        run = store.find(self.run_stage.id, kind="runs")
        if run is None or (self.is_recorded(run) and store.find(self.recording_stage.id, kind="recordings") is None):
            return None
        return run

    @property
    def _without_fit(self) -> bool:
        return not self.config.model.fitted

    def is_recorded(self, run: Record) -> bool:
        """Whether a recording is wanted, and has motion and energy to show: a simulated model of a known system."""
        config = self.config
        if self.control_stage is not None:
            return config.record
        shows = config.model.fitted and config.model.energetic and isinstance(config.data, RandomForce)
        return config.record and shows and bool(run.summary.get("simulated"))

    @property
    def _system_module(self) -> str:
        return plugin_module("mechanics.systems", self.config.system.name)

    @property
    def _model_module(self) -> str:
        return plugin_module("models.kinds", self.config.model.kind)

    def _data_stage(self, data: RandomForce | File) -> Stage:
        options = data.model_dump()
        if isinstance(data, File):
            from repro.tracking.files import file_digest

            options["sha256"] = file_digest(Path(data.path))
            name = Path(data.path).stem
        else:
            if data.regime == "long":
                options.pop("episode_steps")
            name = "long" if data.regime == "long" else f"episodes{data.episode_steps}"
        modules = ("repro.pipeline.stages.data", self._system_module)
        return self._stage("data", f"{self.config.system.name}-{name}", options, {}, modules)

    def _stage(
        self, kind: str, name: str, parts: Mapping[str, Any], upstream: Mapping[str, str], modules: Sequence[str]
    ) -> Stage:
        config = {
            "system": self.config.system.model_dump(),
            "convention": self.config.reading.name,
            "seeds": self.config.members,
            **parts,
        }
        return Stage(kind, name, config, dict(upstream), tuple(modules), self.command)


def _time_step(config: Config) -> float:
    return config.data.time_step if isinstance(config.data, RandomForce) else 0.04
