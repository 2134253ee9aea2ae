"""Configurations of many combinations of options: composed once, then changed group by group without Hydra."""

from functools import cache
from typing import Any

from repro.config.compose import compose, parse
from repro.config.registry import settings
from repro.config.schema import Config


@cache
def _composed(overrides: tuple[str, ...]) -> dict[str, Any]:
    return compose(overrides).config.model_dump()


def changed(overrides: tuple[str, ...], **groups: str | dict[str, Any]) -> Config:
    """What the overrides make, with these options (or contents) of groups; UserError as for a composed one."""
    contents = {group: settings(group, one) if isinstance(one, str) else one for group, one in groups.items()}
    return parse(_composed(overrides) | contents)
