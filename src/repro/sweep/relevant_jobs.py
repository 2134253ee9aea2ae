"""Which jobs of an experiment answer a claim, told from their settings before any of them runs."""

from collections.abc import Mapping, Sequence
from typing import Any

from repro.claims.claims import Claim
from repro.config.schema import Config, RandomForce
from repro.control.controller_options import ControllerOptions
from repro.pipeline.card import run_card
from repro.results.schema import as_text
from repro.sweep.planned_job import PlannedJob


def answering(claim: Claim, jobs: Sequence[PlannedJob]) -> list[PlannedJob]:
    """Those jobs of the claim's experiment that its selectors mean, in their order."""
    foreseen = [(job, _foreseen(job.pipeline.config)) for job in jobs]
    return [job for job, columns in foreseen if any(_agrees(columns, where) for where in claim.selectors)]


def _foreseen(config: Config) -> dict[str, Any]:
    """The columns of the run card and of its closed loops that follow from the configuration at its scale."""
    samples = config.data.samples * config.data.train_fraction if isinstance(config.data, RandomForce) else 0
    asked = getattr(config.data, "train_samples", None)
    n_train = int(samples) if asked is None else min(int(samples), asked)
    notes = {"epochs": getattr(config.optimiser, "epochs", 0)}
    columns = run_card(config, n_train=n_train, n_parameters=0, status=(), notes=notes)
    if isinstance(config.control, ControllerOptions):
        columns |= config.control.columns() | config.task.columns()
    return columns


def _agrees(columns: Mapping[str, Any], where: Mapping[str, Any]) -> bool:
    wanted = {name: value if isinstance(value, list) else [value] for name, value in where.items()}
    return all(as_text(columns.get(name)) in map(as_text, values) for name, values in wanted.items())
