"""How a mistake in the settings is said: one line that names key, value and what is allowed."""

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic import ValidationError

# pydantic names the branch of a union that it has tried; a user has written no such key.
_BRANCHES = ("random_force", "file", "none", "mpc", "energy_shaping")


def meant(word: str, allowed: Iterable[str]) -> str:
    """A hint at the word that was probably meant, or nothing."""
    close = difflib.get_close_matches(word, list(allowed), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def choose(key: str, value: Any, allowed: Sequence[str]) -> str:
    """The line for a value that is not one of the allowed words."""
    return f"{key} = {value!r}: allowed are {', '.join(allowed)}{meant(str(value), allowed)}"


def lines(error: "ValidationError", raw: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """What pydantic found, a line a key; `raw` is what it was given, `prefix` the group that this was part of."""
    problems = error.errors()
    unknown = {problem["loc"][-1] for problem in problems if problem["type"] == "extra_forbidden"}
    for problem in problems:
        path = [str(part) for part in problem["loc"] if part not in _BRANCHES]
        key = ".".join([*([prefix] if prefix else []), *path])
        if problem["type"] == "extra_forbidden":
            allowed = [str(key) for key in _siblings(raw, problem["loc"]) if key not in unknown]
            yield f"{key}: unknown key{meant(path[-1], allowed)}; allowed are {', '.join(sorted(allowed))}"
        elif problem["type"] == "union_tag_invalid":
            name = problem["ctx"]["discriminator"].strip("'")
            yield f"{key}.{name} = {problem['ctx']['tag']!r}: allowed are {problem['ctx']['expected_tags']}"
        elif problem["type"] == "missing":
            yield f"{key}: a value is needed"
        else:
            message = problem["msg"].removeprefix("Input ").removeprefix("Value error, ")
            yield f"{key} = {problem['input']!r}: {message}"


def _siblings(raw: Mapping[str, Any], place: Sequence[Any]) -> Iterable[Any]:
    section: Any = raw
    for part in place[:-1]:
        section = section.get(part, section) if isinstance(section, Mapping) else {}
    return section
