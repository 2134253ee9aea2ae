"""Options of a choice that is a module: checked against the dataclass `Options` that the module declares."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from pydantic import PlainSerializer, PlainValidator, TypeAdapter, ValidationError

from repro.errors import UserError
from repro.plugins.checked import lines
from repro.plugins.options import PluginOptions
from repro.plugins.plugin import not_allowed, plugin, plugin_names

MODELS, OPTIMISERS = "models.kinds", "learning.optimisers"


class OptionsError(ValueError):
    """What is wrong with a group of options, one line per key."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.lines = problems


def checked(group: str, folder: str, raw: Any) -> PluginOptions:
    """The options of a choice from `kind` and plain data; OptionsError names keys, values and what is allowed.

    group   the key of these options in a configuration, e.g. "model"
    folder  of the modules to choose from, e.g. "models.kinds"
    """
    if isinstance(raw, PluginOptions):
        return raw
    if not isinstance(raw, Mapping):
        raise OptionsError([f"{group} = {raw!r}: should be a group of options"])
    kind = raw.get("kind")
    if kind not in plugin_names(folder):
        raise OptionsError([not_allowed(f"{group}.kind", kind, plugin_names(folder))])
    options = {key: value for key, value in raw.items() if key != "kind"}
    try:
        return _adapter(folder, str(kind)).validate_python(options)
    except ValidationError as error:
        raise OptionsError([*lines(error, options, group)]) from None


def stored_options(group: str, folder: str, raw: Any) -> Any:
    """As `checked`, of a stored run; UserError."""
    try:
        return checked(group, folder, raw)
    except OptionsError as error:
        raise UserError(str(error)) from None


@cache
def _adapter(folder: str, kind: str) -> TypeAdapter[PluginOptions]:
    return TypeAdapter(plugin(folder, kind).Options)


def chosen(group: str, folder: str) -> tuple[PlainValidator, PlainSerializer]:
    """How pydantic reads and writes such options, as metadata of an annotated type."""
    return PlainValidator(lambda raw: checked(group, folder, raw)), PlainSerializer(lambda options: options.plain())
