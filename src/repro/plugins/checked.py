"""Plain data checked against types: what is wrong in one line per key, with its value and what is allowed."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields
from functools import cache
from typing import Any

from pydantic import PlainSerializer, PlainValidator, TypeAdapter, ValidationError

from repro.errors import UserError
from repro.plugins.options import PluginOptions
from repro.plugins.plugin import nearest, not_allowed, plugin, plugin_names

# of a key that is not listed: in a pydantic model, in a dataclass
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")


class OptionsError(UserError, ValueError):
    """What is wrong with a group of options, one line per key; a ValueError for pydantic, which goes on to others."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.lines = problems


def lines(error: ValidationError, raw: Any, group: str = "", allowed: Collection[str] = ()) -> Iterator[str]:
    """One line per wrong key of `raw`, the plain data that were checked.

    group: the key that they belong to; allowed: the keys that there are, where `raw` does not hold all of them.
    """
    problems = error.errors()
    unknown = {problem["loc"][-1] for problem in problems if problem["type"] in _UNKNOWN}
    for problem in problems:
        if nested := getattr(problem.get("ctx", {}).get("error"), "lines", None):
            yield from nested
            continue
        path, siblings = _place(raw, problem["loc"], absent=problem["type"] == "missing")
        key = ".".join([group, *path] if group else path)
        if problem["type"] in _UNKNOWN:
            names = sorted({*allowed, *siblings} - unknown)
            yield f"{key}: unknown key{nearest(path[-1], names)}; allowed are {', '.join(names)}"
        elif problem["type"] == "union_tag_invalid":
            name = problem["ctx"]["discriminator"].strip("'")
            yield f"{key}.{name} = {problem['ctx']['tag']!r}: allowed are {problem['ctx']['expected_tags']}"
        elif problem["type"] == "missing":
            yield f"{key}: a value is needed"
        else:
            message = problem["msg"].removeprefix("Input ").removeprefix("Value error, ")
            message = message.replace("valid tuple", "valid list").replace("Tuple should", "list should")
            of_section = problem["type"] == "value_error" and isinstance(problem["input"], Mapping)
            value = "" if of_section else f" = {problem['input']!r}"
            yield f"{key}{value}: {message}".removeprefix(": ").strip()


def validated(kind: Any, group: str, options: Mapping[str, Any]) -> Any:
    """Options of a dataclass from keywords; OptionsError for one that it does not have, or does not allow."""
    try:
        return adapter(kind).validate_python(options)
    except ValidationError as error:
        raise OptionsError([*lines(error, options, group, {field.name for field in fields(kind)})]) from None


def checked(group: str, folder: str, raw: Any) -> Any:
    """The options of a choice from `kind` and plain data; OptionsError as for `validated`.

    group   the key of these options in a configuration, e.g. "model"
    folder  of the modules to choose from, e.g. "models.kinds"
    """
    if isinstance(raw, PluginOptions):
        return raw
    if not isinstance(raw, Mapping):
        raise OptionsError([f"{group} = {raw!r}: should be a group of options"])
    options = dict(raw)
    kind = options.pop("kind", None)
    if kind not in plugin_names(folder):
        raise OptionsError([not_allowed(f"{group}.kind", kind, plugin_names(folder))])
    return validated(plugin(folder, kind).Options, group, options)


def chosen(group: str, folder: str) -> tuple[PlainValidator, PlainSerializer]:
    """How pydantic reads and writes the options of a choice, as metadata of an annotated type."""
    return PlainValidator(lambda raw: checked(group, folder, raw)), PlainSerializer(lambda options: options.plain())


adapter = cache(TypeAdapter[Any])  # what checks options of a dataclass


def _place(raw: Any, place: tuple[int | str, ...], *, absent: bool) -> tuple[list[str], Collection[str]]:
    """The keys to a place as a user writes them, and those beside the last one, which may be `absent`.

    Between them pydantic names the branch of a union that it has tried, which is no key.
    """
    path: list[str] = []
    beside = section = raw
    for number, part in enumerate(place, start=1):
        known = isinstance(part, int) or (isinstance(section, Mapping) and part in section)
        if known or (absent and number == len(place)):
            path.append(str(part))
            beside, section = section, section[part] if known else None
    return path, beside if isinstance(beside, Mapping) else ()
