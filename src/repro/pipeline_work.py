"""The work behind each stage of a pipeline: loads what is upstream, calls the science, writes the card."""

import importlib
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from repro.config import RandomForce, optimiser_class
from repro.data.dataset import Dataset
from repro.mechanics.system import System
from repro.models.model import Model
from repro.protocol import is_literal
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
        system = self.config.system
        return dataset.true_system(system.name, system.damping, system.damping_frame, self.config.reading.name)

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
        (folder / fit.CURVES).write_bytes(
            fitted.path(fit.CURVES).read_bytes() if fitted.path(fit.CURVES).exists() else b""
        )
        return measured | {"card": self._card(fitted)}

    def make_recording(self, folder: Path, run: Record) -> dict[str, Any]:
        """Write the recording from what the run stored."""
        tables = (pd.read_parquet(run.path(name)) for name in (evaluation.TRAJECTORIES, fit.CURVES))
        card = {**run.summary["card"], "test medians": run.summary["median"], "command": self.pipeline.command}
        return recording.record(folder, run.id, self.pipeline.name.replace("-", " "), card, *tables, self.system)

    def _forced(self) -> list[Dataset]:
        """The curriculum's datasets, then D."""
        return [self.data(role) for role in self.pipeline.data_stages if role != "free"]

    def _card(self, fitted: Record) -> dict[str, Any]:
        config = self.config
        data, notes = config.data, fitted.summary["notes"]
        simulated = isinstance(data, RandomForce)
        noises = {name: getattr(data, name, 0.0) for name in ("tau_noise", "qdd_noise", "q_noise", "qd_noise")}
        anchor_row = config.model["kind"] in ("trivial", "degenerate")
        l1 = config.objective.l1_kinetic or config.objective.l1_potential
        hidden = config.model.get("hidden")
        linear = config.model["kind"] == "lagrangian" and _is_linear(config.basis.name)
        return {
            "system": config.system.name,
            "reading": config.reading.name,
            "regime": data.regime if simulated else "file",
            "episode_steps": data.episode_steps if simulated and data.regime == "episodes" else None,
            "labels": data.labels if simulated else "measured",
            "noise": any(noises.values()),
            **noises,
            "reset": data.reset if simulated else None,
            "damping": config.system.damping,
            "n_train": self.data("data").n_train,
            "model": config.model["kind"],
            "basis": config.basis.name if config.model["kind"] == "lagrangian" else None,
            "hidden": None if linear or not hidden else _hidden(hidden),
            "objective": None if anchor_row else config.objective.kind,
            "optimiser": None if anchor_row else config.optimiser["name"] + ("_l1" if l1 else ""),
            "sequence": config.sequence.kind,
            "energies": config.energies.reading,
            "energy_form": config.sequence.energy_form,
            "transform_weight": config.objective.transform_weight,
            "transform_hidden": _hidden(config.model.get("transform_hidden") or []),
            "curriculum": "-".join(str(steps) for steps in config.curriculum.episodes) or None,
            "epochs": notes.get("epochs", 0),
            "seeds": config.members,
            "literal": is_literal(config),
            "member_status": fitted.summary["status"],
            "notes": {key: value for key, value in notes.items() if key != "epochs"},
            "n_parameters": self.model.n_parameters,
        }


def _hidden(hidden: list[int]) -> str:
    """10, 2x32 or 10-5: layers times width where all are equal."""
    if not hidden:
        return ""
    if len(hidden) == 1:
        return str(hidden[0])
    return f"{len(hidden)}x{hidden[0]}" if len(set(hidden)) == 1 else "-".join(map(str, hidden))


def _is_linear(basis: str) -> bool:
    return bool(importlib.import_module(f"repro.models.bases.{basis}").LINEAR)
