"""The trained sub-models that a model is made of: runs that are there, or settings of runs that are made first."""

import re
from collections.abc import Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from repro.config.places import CONF
from repro.config.plugin_options import model_options
from repro.config.schema import Config
from repro.errors import UserError
from repro.plugins.plugin import plugin_module
from repro.tracking.load import Run, load_run

if TYPE_CHECKING:
    from repro.models.context import SubModel
    from repro.models.model import Model


def is_settings(part: str) -> bool:
    """Whether an entry of model.parts is the settings of a run, not the id of one.

    A name of conf/sub_models.yaml, or `system=sip_rod basis=t1 ...`, or without anything to quote on a command line,
    `system:sip_rod+basis:t1+...`.
    """
    return part in _named() or "=" in part or ":" in part


def settings_of(part: str, config: Config) -> Config:
    """The configuration of a sub-model's run: its own settings, with the scale, seeds and reading of the whole."""
    words = re.split(r"[\s+]+", _named().get(part, part).strip())
    own = [word if "=" in word else word.replace(":", "=", 1) for word in words]
    seeds = ",".join(str(seed) for seed in config.members)
    return _composed((*own, f"scale={config.scale.name}", f"seeds=[{seeds}]", f"reading={config.reading.name}"))


def fit_of(id: str, root: Path | None = None) -> Run:
    """The fit behind a stored run, or the fit that the id names; UserError for anything else."""
    found = load_run(id, root=root)
    if found.record.kind == "runs":
        return found.upstream["fit"]
    if found.record.kind != "fits":
        raise UserError(f"model.parts: {found.id} is one of {found.record.kind}; give the id of a run")
    return found


def model_modules(fit: Run) -> list[str]:
    """The modules that hold the model of a fit."""
    names = [plugin_module("models.kinds", fit.config["model"]["kind"])]
    return names + ([plugin_module("models.bases", fit.config["basis"])] if "basis" in fit.config else [])


def model_of(fit: Run) -> "Model":
    """The model of a fit, built for the data it was fitted to."""
    from repro.data.dataset import Dataset
    from repro.pipeline.stages.data import true_system
    from repro.pipeline.stages.fit import build_model

    upstream = fit.upstream
    roles = sorted((role for role in upstream if role.startswith("stage_")), key=_number)
    data = [Dataset.load(upstream[role].record.folder) for role in (*roles, "data")]
    from_file = upstream["data"].config["source"] == "file"
    system = None if from_file else true_system(fit.config["system"], fit.config["convention"])
    basis = fit.config.get("basis", "raw")  # a model without a fit has none, and looks at none
    inner = sorted((role for role in upstream if role.startswith("part_")), key=_number)
    parts = [part_of(upstream[role], fit.config["seeds"]) for role in inner]
    return build_model(model_options(fit.config["model"]), basis, data, system, parts)


def part_of(fit: Run, seeds: Sequence[int]) -> "SubModel":
    """A trained sub-model with the weights of the members of these seeds; UserError where one is missing."""
    from repro.models.context import SubModel
    from repro.pipeline.stages.fit import load_parameters

    there = list(fit.config["seeds"])
    if missing := [seed for seed in seeds if seed not in there]:
        raise UserError(f"model.parts: {fit.id} has the seeds {there}, and not {missing}")
    weights = load_parameters(fit.record.folder).numpy()
    return SubModel(model_of(fit), weights[[there.index(seed) for seed in seeds]])


@cache
def _named() -> dict[str, str]:
    import yaml

    return yaml.safe_load((CONF / "sub_models.yaml").read_text())


@lru_cache(maxsize=64)
def _composed(overrides: tuple[str, ...]) -> Config:
    from repro.config.compose import compose

    return compose((*overrides, "record=false")).config


def _number(role: str) -> int:
    return int(role.rpartition("_")[2])
