"""From the overrides of a job to its settings as plain data, by Hydra, and to a typed configuration."""

import copy
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from repro.config.overrides import REPRODUCED_AT, explicit, first_lines, takes_names
from repro.config.places import CONF, settings_roots
from repro.config.registry import groups
from repro.config.schema import Config
from repro.errors import UserError
from repro.plugins.checked import lines
from repro.tracking.text import hydra_quoted

if TYPE_CHECKING:
    from omegaconf import DictConfig

# The groups of Hydra's own settings: no run reads them, and composing them takes a quarter of the time.
_OWN_GROUPS = ("output", "launcher", "sweeper", "help", "hydra_help", "hydra_logging", "job_logging", "env")


def typed(raw: Mapping[str, Any]) -> Config:
    """Settings as a configuration; UserError with one line per mistake: key, value, and what is allowed."""
    try:
        return Config.model_validate(raw)
    except ValidationError as error:
        raise UserError("\n".join(lines(error, raw))) from None


def composed(overrides: Sequence[str]) -> dict[str, Any]:
    """The settings of a job; UserError for what Hydra does not understand."""
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
    without = [f"~hydra/{group}" for group in _OWN_GROUPS]
    chosen = hydra.compose("config", [f"hydra.searchpath=[{searchpath}]", *without, *choices])
    with open_dict(chosen):
        chosen.pop("hydra", None)
    return chosen
