"""Overrides on a command line: what they may say, and the jobs that their lists make."""

import difflib
import itertools
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from repro.errors import UserError

ROOT = Path(__file__).resolve().parents[2]
CONF, EXPERIMENTS = ROOT / "conf", ROOT / "experiments"


def experiments() -> list[str]:
    """Names of all experiments."""
    return sorted(path.stem for path in EXPERIMENTS.glob("*.yaml"))


def expand(overrides: Sequence[str], paired: bool = False) -> list[tuple[str, ...]]:
    """The jobs of a sweep, as the overrides of each, without repetition.

    `experiment=NAME` takes the lines of that file's `sweep`; in a line, and in the overrides, `key=a,b` makes a job a
    value. `paired` walks the overrides' lists side by side instead of multiplying them. UserError for lists that do not
    pair, or for an override that is not understood.
    """
    overrides = [renamed(override) for override in overrides]
    jobs = [
        line_job + own
        for line in _sweep_lines(overrides)
        for line_job in _product(line)
        for own in (_pairs(overrides) if paired else _product(overrides))
    ]
    return list(dict.fromkeys(jobs))


def renamed(override: str) -> str:
    """`experiment=NAME` and `+experiment=NAME` both mean the file experiments/NAME.yaml."""
    key, _, value = override.partition("=")
    if key not in ("experiment", "+experiment", "+experiments", "+experiments@_global_"):
        return override
    if value not in experiments():
        raise UserError(f"experiment={value}: allowed are {', '.join(experiments())}{meant(value, experiments())}")
    return f"+experiments@_global_={value}"


def _sweep_lines(overrides: Sequence[str]) -> list[list[str]]:
    names = [override.partition("=")[2] for override in overrides if override.startswith("+experiments@_global_=")]
    if not names:
        return [[]]
    content = yaml.safe_load((EXPERIMENTS / f"{names[-1]}.yaml").read_text())
    return [line.split() for line in content.get("sweep", [""])]


def _product(overrides: Sequence[str]) -> Iterable[tuple[str, ...]]:
    return itertools.product(*(_values(override) for override in overrides))


def _pairs(overrides: Sequence[str]) -> Iterable[tuple[str, ...]]:
    lists = [_values(override) for override in overrides]
    lengths = {len(values) for values in lists if len(values) > 1}
    if len(lengths) > 1:
        listed = ", ".join(f"{len(values)} in {override}" for values, override in zip(lists, overrides, strict=True))
        raise UserError(f"paired lists must be of one length: {listed}")
    count = max(lengths, default=1)
    return [tuple(values[index % len(values)] for values in lists) for index in range(count)]


def _values(override: str) -> list[str]:
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException

    try:
        parsed = OverridesParser.create().parse_override(override)
    except HydraException as error:
        raise UserError(f"{override}: not understood ({first_lines(error)}); write key=value or key=a,b") from None
    if not parsed.is_sweep_override():
        return [override]
    key = override.partition("=")[0]
    return [f"{key}={value}" for value in parsed.sweep_string_iterator()]


def check(overrides: Sequence[str]) -> None:
    """UserError for a misspelt group, option or key: Hydra's own advice, to append with +, would mislead."""
    groups = _groups()
    top = sorted({*groups, "seeds", "record", "hydra", "experiments"})
    seen: dict[str, str] = {}
    for override in overrides:
        key, _, value = override.lstrip("+~").partition("=")
        if key in seen:
            raise UserError(f"{key} is given twice: {seen[key]} and {override}; give it once")
        seen[key] = override
        head = key.partition(".")[0].partition("/")[0].partition("@")[0]
        if head not in top:
            raise UserError(f"{override}: unknown key {head!r}{meant(head, top)}; allowed are {', '.join(top)}")
        if key in groups and value not in groups[key] and not override.startswith("~"):
            raise UserError(f"{override}: allowed are {', '.join(groups[key])}{meant(value, groups[key])}")
        if override.startswith("+") and "." in key:
            raise UserError(f"{override}: keys cannot be added; leave out the + and use a key that the schema has")
        if "." in key and head in groups:
            _check_leaf(override, head, key.split(".")[1:], overrides)


def _check_leaf(override: str, group: str, path: Sequence[str], overrides: Sequence[str]) -> None:
    allowed: set[str] = set()
    for option in (CONF / group).glob("*.yaml"):
        section = _yaml(option)
        for part in path[:-1]:
            section = section.get(part, {}) if isinstance(section, dict) else {}
        allowed |= set(section) if isinstance(section, dict) else set()
    if path[-1] not in allowed:
        listed = ", ".join(sorted(allowed)) or "none here"
        raise UserError(f"{override}: unknown key {path[-1]!r}{meant(path[-1], sorted(allowed))}; allowed are {listed}")


def meant(word: str, allowed: Sequence[str]) -> str:
    """A hint at the word that was probably meant, or nothing."""
    close = difflib.get_close_matches(word, allowed, n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def first_lines(error: Exception) -> str:
    """The useful part of what Hydra says, on one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    useful = [line for line in lines if not line.startswith(("full_key", "object_type", "reference_type", "To append"))]
    return "; ".join(useful[:3])


@cache
def _groups() -> dict[str, list[str]]:
    folders = (path for path in CONF.iterdir() if path.is_dir())
    return {path.name: sorted(option.stem for option in path.glob("*.yaml")) for path in folders}


@cache
def _yaml(path: Path) -> Any:
    return yaml.safe_load(path.read_text())
