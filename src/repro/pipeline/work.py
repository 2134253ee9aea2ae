"""The work behind each stage of a pipeline: loads what is upstream, calls the science, writes the card."""

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import pandas as pd
from torch import Tensor

from repro.config.schema import RandomForce
from repro.control.controller_options import ControllerOptions
from repro.data.dataset import Dataset
from repro.evaluation.chains import chain_errors
from repro.evaluation.identifiability import Identifiability
from repro.evaluation.metrics import MetricValues
from repro.evaluation.rollouts import can_simulate
from repro.evaluation.whole_chain import whole_chain_errors
from repro.mechanics.system import System
from repro.models.model import Model
from repro.pipeline.card import summary_of
from repro.pipeline.plan import Pipeline
from repro.pipeline.stages import (
    close_loops as control,
)
from repro.pipeline.stages import (
    data as dataset,
)
from repro.pipeline.stages import (
    evaluate as evaluation,
)
from repro.pipeline.stages import (
    examine as identifiability,
)
from repro.pipeline.stages import (
    fit,
)
from repro.pipeline.stages import (
    record_chain as chain_recording,
)
from repro.pipeline.stages import (
    record_loop as loop_recording,
)
from repro.pipeline.stages import (
    record_run as recording,
)
from repro.pipeline.stages.checkpoint import FileCheckpoint
from repro.pipeline.submodels import part_of
from repro.tracking import progress
from repro.tracking.load import load_run
from repro.tracking.record import Record
from repro.tracking.store import Store


class Work:
    """Does the stages of one pipeline, keeping in memory what several of them need."""

    def __init__(self, pipeline: Pipeline, store: Store) -> None:
        self.pipeline, self.store, self.config = pipeline, store, pipeline.config
        self._datasets: dict[str, Dataset] = {}

    @cached_property
    def system(self) -> System:
        """The true system."""
        return dataset.true_system(self.config.system.model_dump(), self.config.reading.name)

    @property
    def truth(self) -> System | None:
        """The true system where the data come from it, else None."""
        return self.system if isinstance(self.config.data, RandomForce) else None

    @cached_property
    def model(self) -> Model:
        """The model, built for the final dataset."""
        upstream, root = self.pipeline.fit_stage.upstream, self.store.paths.root
        fits = [load_run(upstream[role], root=root) for role in upstream if role.startswith("part_")]
        parts = [part_of(each, self.config.members) for each in fits]
        return fit.build_model(self.config.model, self.config.basis.name, self.forced, self.truth, parts)

    @property
    def recipe(self) -> fit.Recipe:
        """What to minimise on which data."""
        return fit.Recipe(self.config.objective.model_dump(), self.config.sequence.model_dump(), self.config.members)

    @property
    def forced(self) -> list[Dataset]:
        """The curriculum's datasets, then D."""
        return [self.data(role) for role in self.pipeline.data_stages if role != "free"]

    @property
    def free(self) -> Dataset | None:
        """D_H, where the sequence asks for it."""
        return self.data("free") if "free" in self.pipeline.data_stages else None

    def data(self, role: str) -> Dataset:
        """A finished dataset by its role."""
        if role not in self._datasets:
            folder = self.store.paths.folder("data", self.pipeline.data_stages[role].id)
            self._datasets[role] = Dataset.load(folder)
        return self._datasets[role]

    def make_data(self, folder: Path, role: str) -> dict[str, Any]:
        """Simulate or read one dataset."""
        options = dict(self.pipeline.data_stages[role].config)
        for key in ("system", "convention", "seeds", "sha256"):
            options.pop(key, None)
        make = {
            "random_force": dataset.make_forced,
            "free_motion": dataset.make_free,
            "file": dataset.read_recording,
        }[options.pop("source")]
        return make(folder, self.system, self.config.members, options)

    def make_fit(self, folder: Path) -> dict[str, Any]:
        """Fit the ensemble, resuming where an interrupted attempt left off."""
        config = self.config
        fitted, seconds = fit.fit(
            self.model,
            self.recipe,
            fit.build_optimiser(config.optimiser, config.device),
            self.forced,
            self.free,
            self.system,
            lambda fraction, text: progress.report(0.05 + 0.85 * fraction, text),
            FileCheckpoint(folder),
        )
        if reason := fitted.notes.get("not_captured"):
            progress.notice(f"without CUDA graphs, so more slowly: {reason}")
        return fit.keep(folder, fitted, config.members, seconds)

    def make_control(self, folder: Path, fitted: Record) -> dict[str, Any]:
        """Close the loops."""
        config = self.config
        assert isinstance(config.control, ControllerOptions)
        canonical = config.energies.gauge.startswith("canonical")
        plan = control.LoopPlan(config.control, config.task, config.scale.loops, canonical)
        return control.drive(
            folder,
            self.model,
            fit.load_parameters(fitted.folder).numpy(),
            config.members,
            self.system,
            self.data("data"),
            plan,
            progress.report,
        )

    def make_run(self, folder: Path, fitted: Record, closed: Record | None = None) -> dict[str, Any]:
        """Measure, and write the run card that every table is made from."""
        status = fitted.summary["status"]
        ensemble = evaluation.Fit(
            self.model,
            fit.load_parameters(fitted.folder),
            self.config.members,
            status,
            fitted.summary["seconds"],
            fitted.summary["notes"],
        )
        identified = self.identified()
        if identified:
            identifiability.keep(folder, identified, self.config.members)
        measured = evaluation.measure(
            folder,
            ensemble,
            self.data("data"),
            self.truth,
            self.config.energies.gauge,
            self.free,
            [
                *self._found(identified),
                *self._chained(ensemble.parameters),
                *self._chained_whole(),
                *self._watched(fitted),
            ],
            self.config.energies.horizons,
        )
        copyfile(fitted.path(fit.CURVES), folder / fit.CURVES)
        if closed is not None:
            for name in (control.LOOPS, control.TRAJECTORIES):
                copyfile(closed.path(name), folder / name)
            measured["median"] |= {"success": closed.summary["success"]}
        described = summary_of(
            self.config,
            n_train=self.data("data").n_train,
            n_parameters=self.model.n_parameters,
            status=status,
            notes=fitted.summary["notes"],
        )
        return measured | described | {"simulated": can_simulate(self.model)}

    def _found(self, identified: dict[str, list[Identifiability]]) -> Iterator[MetricValues]:
        if identified:
            yield from identifiability.metrics([*identified.values()][-1])

    def _chained(self, parameters: Tensor) -> Iterator[MetricValues]:
        if self.config.chain:
            yield from chain_errors(self.model, parameters, self.system, self.config.chain, "test")

    def _chained_whole(self) -> Iterator[MetricValues]:
        config = self.config
        if config.whole_chain and isinstance(config.data, RandomForce):
            yield from whole_chain_errors(
                self.data("data"), config.members, self.system, config.data.tau_noise, config.whole_chain, "test"
            )

    def _watched(self, fitted: Record) -> Iterator[MetricValues]:
        curves = pd.read_parquet(fitted.path(fit.CURVES))
        margins = curves[curves["name"] == "passivity_margin"].groupby("member")["value"].max()
        if len(margins):
            yield MetricValues("train", "passivity_margin_worst", margins.reindex(self.config.members).to_numpy(), "1")

    def identified(self) -> dict[str, list[Identifiability]]:
        """What the data can tell of a linear model, by the phase of its training; empty for other models."""
        if not identifiability.applies(self.model, self.config.objective.kind):
            return {}
        forced = [identifiability.shortened(each) for each in self.forced]
        free = None if self.free is None else identifiability.shortened(self.free)
        phases = fit.phases_of(self.model, self.recipe, forced, free, self.system)
        return identifiability.examine(self.model, phases)

    def make_recording(self, folder: Path, run: Record) -> dict[str, Any]:
        """Write the recording from what the run stored."""
        if self.pipeline.control_stage is not None:
            return self._record_loop(folder, run, self.store.paths.folder("control", self.pipeline.control_stage.id))
        card = {**run.summary["card"], "test medians": run.summary["median"], "command": self.pipeline.command}
        title = self.pipeline.name.replace("-", " ")
        links = self.pipeline.recorded_chain
        if links is not None:
            weights = fit.load_parameters(self.store.paths.folder("fits", self.pipeline.fit_stage.id))
            return chain_recording.record(
                folder, run.id, title, card, self.model, weights, self.config.members, self.system, links
            )
        trajectories, curves = (pd.read_parquet(run.path(name)) for name in (evaluation.TRAJECTORIES, fit.CURVES))
        return recording.record(folder, run.id, title, card, trajectories, curves, self.system)

    def _record_loop(self, folder: Path, run: Record, closed: Path) -> dict[str, Any]:
        first = pd.read_parquet(closed / control.LOOPS).iloc[0].to_dict()
        card = {**run.summary["card"], "first loop": first, "command": self.pipeline.command}
        with np.load(closed / control.FIRST) as stored:
            loop = dict(stored)
        title = self.pipeline.name.replace("-", " ")
        return loop_recording.record(folder, run.id, title, card, loop, self.system)
