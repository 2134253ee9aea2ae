"""The configuration that a run would have, had only its options been chosen: what its settings are compared with."""

from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Any

from repro.config.places import CONF
from repro.config.registry import groups, read_settings, settings
from repro.config.schema import Config
from repro.tracking.plain_data import flattened

CHOICE = ("name", "kind", "source")  # the keys by which the options of a group differ, the first one first


def defaults_of(config: Config) -> Config:
    """The same option of every group (conf/GROUP/OPTION.yaml), and nothing else set."""
    chosen = config.model_dump(mode="json")
    return _defaults(tuple((group, _nearest(group, chosen[group])) for group in groups()))


@lru_cache(maxsize=256)
def _defaults(options: tuple[tuple[str, str], ...]) -> Config:
    outside = {key: value for key, value in read_settings(CONF / "config.yaml").items() if key != "defaults"}
    return Config.model_validate({**outside, **{group: settings(group, option) for group, option in options}})


def _nearest(group: str, section: Mapping[str, Any]) -> str:
    """The option of a group that a section was made from: of the same name or kind, with the fewest other values."""
    own = flattened(section)

    def distance(option: str) -> tuple[bool | int, ...]:
        other = flat(group, option)
        differing = sum(own.get(key) != other.get(key) for key in own.keys() | other.keys())
        return (*(own.get(key) != other.get(key) for key in CHOICE), differing)

    return min(groups()[group], key=distance)


@cache
def flat(group: str, option: str) -> dict[str, Any]:
    """The settings of an option by dotted key."""
    return flattened(settings(group, option))
