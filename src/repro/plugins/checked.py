"""Plain data checked against types: what is wrong in one line per key, with its value and what is allowed."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from repro.errors import UserError
from repro.plugins.plugin import nearest

# of a key that is not listed: in a pydantic model, in a dataclass
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")


def lines(
    error: ValidationError, raw: Mapping[str, Any], group: str = "", allowed: Collection[str] = ()
) -> Iterator[str]:
    """One line per wrong key of `raw`, the plain data that were checked.

    group: the key that they belong to; allowed: the keys that there are, where `raw` does not hold all of them.
    """
    problems = error.errors()
    unknown = {problem["loc"][-1] for problem in problems if problem["type"] in _UNKNOWN}
    for problem in problems:
        if nested := getattr(problem.get("ctx", {}).get("error"), "lines", None):
            yield from nested
            continue
        path, siblings = _place(raw, problem["loc"])
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
            yield f"{key} = {problem['input']!r}: {message}"


def validated(kind: type[Any], group: str, options: Mapping[str, Any]) -> Any:
    """Options of a dataclass from keywords; UserError as `lines` has it."""
    try:
        return TypeAdapter(kind).validate_python(options)
    except ValidationError as error:
        raise UserError("\n".join(lines(error, options, group, kind.__dataclass_fields__))) from None


def _place(raw: Any, place: tuple[int | str, ...]) -> tuple[list[str], Collection[str]]:
    """The keys to a place as a user writes them, and those beside the last one.

    Between them pydantic names the branch of a union that it has tried, which is no key.
    """
    path, section = [], raw
    for part in place[:-1]:
        if isinstance(section, Mapping) and part not in section:
            continue
        path.append(str(part))
        section = section[part]
    return [*path, *map(str, place[-1:])], section if isinstance(section, Mapping) else ()
