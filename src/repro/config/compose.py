"""From overrides to checked configurations, by Hydra; what was composed before is read from a file."""

import copy
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from repro.config.composed_cache import Cache
from repro.config.error_lines import lines
from repro.config.overrides import (
    EXPERIMENT,
    REPRODUCED_AT,
    check,
    experiment_of,
    explicit,
    first_lines,
    renamed,
    takes_names,
)
from repro.config.places import CONF, settings_roots
from repro.config.registry import groups
from repro.config.rules import impossible
from repro.config.schema import Config
from repro.errors import UserError
from repro.tracking.text import hydra_quoted

if TYPE_CHECKING:
    from omegaconf import DictConfig

# The groups of Hydra's own settings: no run reads them, and composing them takes a quarter of the time.
_OWN_GROUPS = ("output", "launcher", "sweeper", "help", "hydra_help", "hydra_logging", "job_logging", "env")
Overrides = tuple[str, ...]  # of one job
WITHOUT_HYDRAS_OWN = tuple(f"~hydra/{group}" for group in _OWN_GROUPS)


@dataclass(frozen=True)
class Composed:
    """One job of a sweep: its overrides, and the configuration that they make."""

    overrides: tuple[str, ...]
    config: Config

    @property
    def command(self) -> str:
        """The command line that repeats it."""
        shown = (override.replace(EXPERIMENT, "experiment=") for override in self.overrides)
        return shlex.join(["repro", "run", *shown])


def plan(
    jobs: Sequence[Overrides],
    cache: Path | None = None,
    on_unknown: Callable[[list[Overrides]], None] = lambda jobs: None,
) -> list[Composed]:
    """All jobs (the overrides of each), composed and checked before any of them runs; UserError for the first mistake.

    cache       a folder that keeps what was composed and checked, so that a known job costs nothing
    on_unknown  takes the jobs that are not known, where there are any, before the first of them is composed
    """
    caches = {name: Cache.of(cache, name) for name in dict.fromkeys(experiment_of(job) for job in jobs)}
    checked = {job: caches[experiment_of(job)].checked(job) for job in jobs}
    unknown = [job for job in checked if checked[job] is None]
    for job in unknown:
        check(job)
    if unknown:
        on_unknown(unknown)
        checked |= zip(unknown, _checked(unknown, caches), strict=True)
    for one in caches.values():
        one.save()
    return [Composed(job, config) for job in jobs if (config := checked[job]) is not None]


def compose(overrides: Sequence[str], cache: Path | None = None) -> Composed:
    """One configuration; UserError names key, value and what is allowed."""
    (composed,) = plan([tuple(renamed(override) for override in overrides)], cache)
    return composed


def parse(raw: Mapping[str, Any]) -> Config:
    """Check a composed configuration; UserError with one line per mistake: key, value, and what is allowed."""
    try:
        config = Config.model_validate(raw)
    except ValidationError as error:
        raise UserError("\n".join(lines(error, raw))) from None
    if problems := [*impossible(config)]:
        raise UserError("\n".join(problems))
    return config


def _checked(jobs: Sequence[Overrides], caches: Mapping[str, Cache]) -> Iterator[Config]:
    """Configurations in the order of the jobs, each stored in the cache of its experiment."""
    for job in jobs:
        name = experiment_of(job)
        raw = caches[name].raw(job) or _composed(job)
        if (raw["experiment"] or "") != name:
            raise UserError(f"experiments/{name}.yaml: experiment = {raw['experiment']!r}: must be {name!r}")
        config = parse(raw)
        caches[name].keep(job, raw, config)
        yield config


def _composed(overrides: Sequence[str]) -> dict[str, Any]:
    import yaml
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException
    from omegaconf import OmegaConf
    from omegaconf.errors import ConfigAttributeError, ConfigKeyError, OmegaConfBaseException

    try:
        config = copy.deepcopy(_chosen(tuple(o for o in overrides if not _is_value(o))))
        for override in OverridesParser.create().parse_overrides([o for o in overrides if _is_value(o)]):
            try:
                key = override.key_or_group
                OmegaConf.update(config, key, override.value(), merge=True, force_add=takes_names(key))
            except (ConfigAttributeError, ConfigKeyError):
                raise UserError(f"{override.key_or_group}: unknown key; the chosen option has no such key") from None
        resolved = OmegaConf.to_container(config, resolve=True, throw_on_missing=False)
    except (HydraException, OmegaConfBaseException, yaml.YAMLError) as error:
        raise UserError(first_lines(error)) from None
    assert isinstance(resolved, dict)
    resolved["explicit"] = resolved.get("explicit") or explicit(overrides)
    return {str(key): value for key, value in resolved.items() if key != REPRODUCED_AT}


def _is_value(override: str) -> bool:
    """Whether an override sets a value (data.samples=100, seeds=3), which Hydra sets after all choices are made."""
    key = override.partition("=")[0]
    return key[0] not in "+~" and key.partition(".")[0] != "hydra" and ("." in key or key not in groups())


@lru_cache(maxsize=256)
def _chosen(choices: tuple[str, ...]) -> "DictConfig":
    """What Hydra makes of an experiment and the options of groups; jobs that differ in values alone share it."""
    import hydra
    from hydra.core.global_hydra import GlobalHydra
    from omegaconf import open_dict

    if not GlobalHydra.instance().is_initialized():
        hydra.initialize_config_dir(str(CONF), version_base="1.3")
    folders = [*settings_roots(), *(root / CONF.name for root in settings_roots()[1:] if (root / CONF.name).is_dir())]
    searchpath = ",".join(hydra_quoted(f"file://{folder}") for folder in folders)
    composed = hydra.compose("config", [f"hydra.searchpath=[{searchpath}]", *WITHOUT_HYDRAS_OWN, *choices])
    with open_dict(composed):
        composed.pop("hydra", None)
    return composed
