"""The work behind each stage of a pipeline: loads what is upstream, calls the science, writes the card."""

from functools import cached_property
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Any

import pandas as pd

from repro.card import run_card
from repro.config import RandomForce
from repro.data.dataset import Dataset
from repro.mechanics.system import System
from repro.models.model import Model
from repro.options import optimiser_class
from repro.stages import dataset, evaluation, fit, recording
from repro.stages.checkpoint import FileCheckpoint
from repro.tracking import progress
from repro.tracking.record import Record
from repro.tracking.store import Store

if TYPE_CHECKING:
    from repro.pipeline import Pipeline


class Work:
    """Does the stages of one pipeline, keeping in memory what several of them need."""

    def __init__(self, pipeline: "Pipeline", store: Store) -> None:
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
        return fit.build_model(self.config.model, self.config.basis.name, self._forced(), self.truth)

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
        settings = {key: value for key, value in config.optimiser.items() if key not in ("name", "kind")}
        recipe = fit.Recipe(config.objective.model_dump(), config.sequence.model_dump(), config.members)
        fitted, seconds = fit.fit(
            self.model,
            recipe,
            optimiser_class(config.optimiser["kind"])(**settings),
            self._forced(),
            self.data("free") if "free" in self.pipeline.data_stages else None,
            self.system,
            lambda fraction, text: progress.report(0.05 + 0.85 * fraction, text),
            FileCheckpoint(folder),
        )
        return fit.keep(folder, fitted, config.members, seconds)

    def make_run(self, folder: Path, fitted: Record) -> dict[str, Any]:
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
        measured = evaluation.measure(folder, ensemble, self.data("data"), self.truth, self.config.energies.reading)
        copyfile(fitted.path(fit.CURVES), folder / fit.CURVES)
        card = run_card(
            self.config,
            n_train=self.data("data").n_train,
            n_parameters=self.model.n_parameters,
            status=status,
            notes=fitted.summary["notes"],
        )
        return measured | {"card": card}

    def make_recording(self, folder: Path, run: Record) -> dict[str, Any]:
        """Write the recording from what the run stored."""
        trajectories, curves = (pd.read_parquet(run.path(name)) for name in (evaluation.TRAJECTORIES, fit.CURVES))
        card = {**run.summary["card"], "test medians": run.summary["median"], "command": self.pipeline.command}
        title = self.pipeline.name.replace("-", " ")
        return recording.record(folder, run.id, title, card, trajectories, curves, self.system)

    def _forced(self) -> list[Dataset]:
        """The curriculum's datasets, then D."""
        return [self.data(role) for role in self.pipeline.data_stages if role != "free"]
