"""From overrides to checked configurations, by Hydra; what was composed before is read from a file."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from repro.combinations import impossible
from repro.config import Config
from repro.errors import UserError
from repro.messages import lines
from repro.options import model_options, optimiser_options
from repro.overrides import EXPERIMENT, check, experiment_of, first_lines, renamed
from repro.settings import CONF, ROOT, digest
from repro.tracking.files import write_atomically

NEEDS_QUOTES = set("[]{}() $*;&|")


@dataclass(frozen=True)
class Composed:
    """One job of a sweep: its overrides, and the configuration that they make."""

    overrides: tuple[str, ...]
    config: Config

    @property
    def command(self) -> str:
        """The command line that repeats it."""
        shown = (override.replace(EXPERIMENT, "experiment=") for override in self.overrides)
        return " ".join(["repro run", *(f"'{o}'" if set(o) & NEEDS_QUOTES else o for o in shown)])


def plan(jobs: Sequence[tuple[str, ...]], cache: Path | None = None) -> list[Composed]:
    """All jobs (the overrides of each), composed and checked before any of them runs; UserError for the first mistake.

    cache: a folder that keeps what Hydra composed, so that a known job costs nothing.
    """
    raw: dict[tuple[str, ...], dict[str, Any]] = {}
    for experiment in dict.fromkeys(experiment_of(job) for job in jobs):
        file = None if cache is None else cache / f"{experiment or 'single'}.json"
        raw |= _composed_all([job for job in jobs if experiment_of(job) == experiment], file, digest(experiment))
    for job in jobs:
        if experiment_of(job) != (raw[job]["experiment"] or ""):
            name = experiment_of(job)
            raise UserError(f"experiments/{name}.yaml: experiment = {raw[job]['experiment']!r}: must be {name!r}")
    return [Composed(job, parse(raw[job])) for job in jobs]


def compose(overrides: Sequence[str], cache: Path | None = None) -> Composed:
    """One configuration; UserError names key, value and what is allowed."""
    (composed,) = plan([tuple(renamed(override) for override in overrides)], cache)
    return composed


def parse(raw: Mapping[str, Any]) -> Config:
    """Check a composed configuration; UserError with a line a mistake: key, value, and what is allowed."""
    try:
        config = Config.model_validate(raw)
    except ValidationError as error:
        raise UserError("\n".join(lines(error, raw))) from None
    options = {"model": model_options(config.model), "optimiser": optimiser_options(config.optimiser)}
    config = config.model_copy(update=options)
    if problems := [*impossible(config)]:
        raise UserError("\n".join(problems))
    return config


def _composed(overrides: Sequence[str]) -> dict[str, Any]:
    import hydra
    import yaml
    from hydra.core.global_hydra import GlobalHydra
    from hydra.errors import HydraException
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    check(overrides)
    try:
        if not GlobalHydra.instance().is_initialized():
            hydra.initialize_config_dir(str(CONF), version_base="1.3")
        composed = hydra.compose("config", [f"hydra.searchpath=[file://{ROOT}]", *overrides])
        resolved = OmegaConf.to_container(composed, resolve=True, throw_on_missing=False)
    except (HydraException, OmegaConfBaseException, yaml.YAMLError) as error:
        raise UserError(first_lines(error)) from None
    assert isinstance(resolved, dict)
    return {str(key): value for key, value in resolved.items() if key != "hydra"}


def _composed_all(
    jobs: Sequence[tuple[str, ...]], cache: Path | None, settings: str
) -> dict[tuple[str, ...], dict[str, Any]]:
    known = {} if cache is None else _load(cache, settings)
    raw = {job: known.get(" ".join(job)) or _composed(job) for job in jobs}
    added = {" ".join(job): content for job, content in raw.items() if " ".join(job) not in known}
    if cache is not None and added:
        # A cache that cannot be written (read-only results) costs time, nothing else.
        with suppress(OSError):
            write_atomically(cache, json.dumps({"settings": settings, "jobs": known | added}).encode())
    return raw


def _load(cache: Path, settings: str) -> dict[str, Any]:
    try:
        stored = json.loads(cache.read_bytes())
    except (OSError, ValueError):
        return {}
    return stored["jobs"] if stored["settings"] == settings else {}
