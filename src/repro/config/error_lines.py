"""Formats errors of a configuration: one line with key, value and what is allowed."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from repro.data.data_options import DataSource
from repro.plugins.plugin import nearest

if TYPE_CHECKING:
    from pydantic import ValidationError

# pydantic adds the branch of a union that it has tried to the path of a key; a user has written no such key.
_BRANCHES = tuple(word for source in get_args(DataSource) for word in get_args(get_type_hints(source)["source"]))
# of a key that is not listed: in a pydantic model, in a dataclass
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")


def lines(error: "ValidationError", raw: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """One line per wrong key of `raw`, the plain data that were checked; `prefix` is the group that they belong to."""
    problems = error.errors()
    unknown = {problem["loc"][-1] for problem in problems if problem["type"] in _UNKNOWN}
    for problem in problems:
        if nested := getattr(problem.get("ctx", {}).get("error"), "lines", None):
            yield from nested
            continue
        path = [str(part) for part in problem["loc"] if part not in _BRANCHES]
        key = ".".join([*([prefix] if prefix else []), *path])
        if problem["type"] in _UNKNOWN:
            allowed = [str(key) for key in _siblings(raw, problem["loc"]) if key not in unknown]
            yield f"{key}: unknown key{nearest(path[-1], allowed)}; allowed are {', '.join(sorted(allowed))}"
        elif problem["type"] == "union_tag_invalid":
            name = problem["ctx"]["discriminator"].strip("'")
            yield f"{key}.{name} = {problem['ctx']['tag']!r}: allowed are {problem['ctx']['expected_tags']}"
        elif problem["type"] == "missing":
            yield f"{key}: a value is needed"
        else:
            message = problem["msg"].removeprefix("Input ").removeprefix("Value error, ")
            message = message.replace("valid tuple", "valid list").replace("Tuple should", "list should")
            yield f"{key} = {problem['input']!r}: {message}"


def _siblings(raw: Mapping[str, Any], place: Sequence[Any]) -> Iterable[Any]:
    section: object = raw
    for part in place[:-1]:
        section = section.get(part, section) if isinstance(section, Mapping) else {}
    return section if isinstance(section, Mapping) else ()
