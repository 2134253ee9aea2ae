"""From the overrides of a job to its settings as plain data, by Hydra, and to a typed configuration."""

import pickle
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache, reduce
from typing import Any

from pydantic import ValidationError

from repro.config.overrides import EXPERIMENT, REPRODUCED_AT, experiment_of, explicit, first_lines, parsed
from repro.config.places import CONF, EXPERIMENTS, experiment_files, option_file, settings_roots
from repro.config.registry import groups, merged, read_settings, settings
from repro.config.schema import Config
from repro.errors import UserError
from repro.plugins.checked import lines


def typed(raw: Mapping[str, Any]) -> Config:
    """Settings as a configuration; UserError with one line per mistake: key, value, and what is allowed."""
    try:
        return Config.model_validate(raw)
    except ValidationError as error:
        raise UserError("\n".join(lines(error, raw))) from None


def composed(overrides: Sequence[str]) -> dict[str, Any]:
    """The settings of a job; UserError for what Hydra does not understand."""
    values = [override for override in overrides if _is_value(override)]
    choices = tuple(override for override in overrides if not _is_value(override))
    resolved = _without_hydra(choices, values)
    if resolved is None:
        resolved = _by_hydra(choices, values)
    resolved["explicit"] = resolved.get("explicit") or explicit(overrides)
    return {key: value for key, value in resolved.items() if key != REPRODUCED_AT}


def _by_hydra(choices: tuple[str, ...], values: Sequence[str]) -> dict[str, Any]:
    """The settings with options and values of any kind, interpolations included."""
    import yaml
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    try:
        config = OmegaConf.create(pickle.loads(_chosen(choices)))
        for override in OverridesParser.create().parse_overrides([*values]):
            # A key that there is not is named, with those that there are, by the type that takes it.
            OmegaConf.update(config, override.key_or_group, override.value(), merge=True, force_add=True)
        resolved = OmegaConf.to_container(config, resolve=True, throw_on_missing=False)
    except (HydraException, OmegaConfBaseException, yaml.YAMLError) as error:
        raise UserError(first_lines(error)) from None
    assert isinstance(resolved, dict)
    return {str(key): value for key, value in resolved.items()}


def _without_hydra(choices: tuple[str, ...], values: Sequence[str]) -> dict[str, Any] | None:
    """The same in an eighth of the time; None unless keys that there are get numbers, texts and lists."""
    made = _put_together(choices)
    if made is None or b"${" in made:
        return None
    config: dict[str, Any] = pickle.loads(made)
    for override in values:
        place: Any = config
        value = _plain_value(override)
        *sections, key = override.partition("=")[0].split(".")
        for section in sections:
            place = place.get(section) if isinstance(place, dict) else None
        if value is None or not isinstance(place, dict) or isinstance(place.get(key, {}), dict):
            return None
        (place[key],) = pickle.loads(value)
    return config


@lru_cache(maxsize=1024)
def _plain_value(override: str) -> bytes | None:
    """The value of an override, pickled in a tuple; None where it is no number, text or list of these."""
    text = override.partition("=")[2]
    if re.fullmatch(r"0|-?[1-9]\d*", text):  # the grammar of Hydra takes as long to load as all else
        return pickle.dumps((int(text),))
    if re.fullmatch(r"[a-z]\w*", text) and text not in ("true", "false", "null", "inf", "nan"):
        return pickle.dumps((text,))
    try:
        value = parsed(override).value() if "${" not in override else {}
    except UserError:
        return None
    items = value if isinstance(value, list) else [value]
    plain = all(isinstance(item, str | int | float | None) for item in items)
    return pickle.dumps((value,)) if plain else None


def _is_value(override: str) -> bool:
    """Whether an override sets a value (data.samples=100, seeds=3), which Hydra sets after all choices are made."""
    key = override.partition("=")[0]
    return key[0] not in "+~" and ("." in key or key not in groups())


# Pickled, because each job sets values in a copy of its own.
@lru_cache(maxsize=256)
def _chosen(choices: tuple[str, ...]) -> bytes:
    """What Hydra makes of an experiment and the options of groups; jobs that differ in values alone share it."""
    import hydra
    from hydra.core.global_hydra import GlobalHydra
    from hydra.core.override_parser.types import Quote, QuotedString
    from omegaconf import OmegaConf, open_dict

    if not GlobalHydra.instance().is_initialized():
        hydra.initialize_config_dir(str(CONF), version_base="1.3")
    folders = [*settings_roots(), *(root / CONF.name for root in settings_roots()[1:] if (root / CONF.name).is_dir())]
    searchpath = ",".join(QuotedString(f"file://{folder}", Quote.single).with_quotes() for folder in folders)
    config = hydra.compose("config", [f"hydra.searchpath=[{searchpath}]", *choices])
    with open_dict(config):
        config.pop("hydra", None)
    return pickle.dumps(OmegaConf.to_container(config))


@lru_cache(maxsize=256)
def _put_together(choices: tuple[str, ...]) -> bytes | None:
    """The same, from the files of the defaults, the experiment and the options alone, in a fraction of the time.

    An option stands under the key of its group, and the values of the experiment are laid over it. Options and
    experiments of the user's plugins, which need not be of this form, are left to Hydra: None.
    """
    whole = read_settings(CONF / "config.yaml")
    name = experiment_of(choices)
    own = read_settings(experiment_files()[name]) if name else {}
    chosen = dict(choice.split("=", 1) for choice in choices if not choice.startswith(EXPERIMENT))
    options = _overridden(whole) | _overridden(own) | chosen
    files = {group: option_file(group, option) for group, option in options.items()}
    ours = all(group in groups() and file.is_file() and file.is_relative_to(CONF) for group, file in files.items())
    if not ours or (name and not experiment_files()[name].is_relative_to(EXPERIMENTS)):
        return None
    plain = reduce(merged, (whole, own), {group: settings(group, option) for group, option in options.items()})
    return pickle.dumps({key: value for key, value in plain.items() if key != "defaults"})


def _overridden(layer: Mapping[str, Any]) -> dict[str, str]:
    """The options that the defaults or an experiment (`override /GROUP: OPTION`) choose; another entry is no group."""
    listed = layer.get("defaults", [])
    if listed[-1:] == ["_self_"]:  # the layer's own values are laid over the options
        listed = listed[:-1]
    entries = [entry.items() if isinstance(entry, dict) else [(str(entry), "")] for entry in listed]
    return {key.removeprefix("override /"): option for items in entries for key, option in items}
