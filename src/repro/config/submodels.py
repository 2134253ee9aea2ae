"""The trained sub-models that a model is made of: stored runs, or settings of runs that are made first."""

import re
from functools import cache, lru_cache

from repro.config.composition import composed, typed
from repro.config.overrides import check, renamed
from repro.config.places import CONF
from repro.config.registry import read_settings
from repro.config.schema import Config
from repro.errors import UserError
from repro.tracking.load import load_stage
from repro.tracking.plain_data import Json
from repro.tracking.record import Record


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
    # What a scale cuts it cuts of the parts as well, whose settings are no command line.
    shared = {**config.model_dump(mode="json", include={"scale", "reading"}), "seeds": config.members, "explicit": []}
    return typed({**_composed(tuple(own)), **shared})


def fit_of(id: str) -> Record:
    """The fit behind a stored run, or the fit that the id names; UserError for anything else."""
    stage = load_stage(id)
    if stage.kind == "runs":
        return stage.upstream["fit"]
    if stage.kind != "fits":
        raise UserError(f"model.parts: {stage.id} is one of {stage.kind}; give the id of a run")
    return stage


def n_coordinates(part: str, config: Config) -> int:
    """The number of coordinates of a sub-model; UserError for an id that is not stored."""
    from repro.data.dataset import Dataset
    from repro.mechanics.system import load_system

    if is_settings(part):
        return load_system(settings_of(part, config).system_options).n_q
    return int(Dataset.load(fit_of(part).upstream["data"].folder).q.shape[-1])


@cache
def _named() -> dict[str, str]:
    return read_settings(CONF / "sub_models.yaml")


@lru_cache(maxsize=64)
def _composed(overrides: tuple[str, ...]) -> Json:
    job = [renamed(override) for override in (*overrides, "record=false")]
    check([*job, "scale=smoke", "seeds=1", "reading=physical"])  # which the whole has for all of its parts
    return composed(job)
