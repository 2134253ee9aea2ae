"""Overrides on a command line: what they may say, and the jobs that their lists make."""

import itertools
import re
from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING

from repro.config import registry
from repro.config.places import CONF, check_checkout, experiment_files
from repro.errors import UserError
from repro.plugins.plugin import nearest
from repro.tracking.paths import project_folder

if TYPE_CHECKING:
    from hydra.core.override_parser.types import Override

EXPERIMENT = "+experiments@_global_="  # how Hydra spells experiment=
REPRODUCED_AT = "reproduced_at"  # lists scales, or [name]: by its name alone; no part of a configuration
# What a scale cuts, unless the command line gives it.
CUT_BY_SCALE = (
    *("data.samples", "curriculum.samples", "chain", "whole_chain"),
    *("optimiser.epochs", "optimiser.iterations", "optimiser.budget_s"),
    *("sequence.initial_angles", "sequence.pretraining_epochs", "energies.horizons"),
    *("task.seconds", "task.initial_states", "task.x_des", "seeds"),
)
# What may be added to a job of an experiment without making it another setting.
SAME_SETTING = ("scale", "seeds", "record")


def experiments(reproduced_at: str = "") -> list[str]:
    """Names of all experiments, or of those beside the paper that a reproduction at this scale includes."""
    check_checkout()
    files = experiment_files()
    if not reproduced_at:
        return [*files]
    names = [name for name, path in files.items() if path.parent.parent == project_folder()]
    scales = {name: registry.read_settings(experiment_files()[name]).get(REPRODUCED_AT) for name in names}
    return [name for name in names if reproduced_at in (scales[name] or [reproduced_at])]


def expand(
    overrides: Sequence[str], *, paired: bool = False, lines: bool = True, first_of_line: bool = False
) -> list[tuple[str, ...]]:
    """The jobs of a sweep, as the overrides of each, without repetition.

    `experiment=NAME` takes the `lines` of that file's `sweep`, whose keys the overrides replace; in a line, and in the
    overrides, `key=a,b` makes one job per value; `first_of_line` takes the first job of every line alone, `paired`
    walks the overrides' lists side by side, not as a product.
    UserError for lists that do not pair, or for an override that is not understood.
    """
    overrides = [renamed(override) for override in overrides]
    if lines:  # first, so that what is given beside it follows the lines of its file
        overrides.sort(key=lambda override: not override.startswith(EXPERIMENT))
    replaced = {key_of(override) for override in overrides}
    jobs = [
        (*(override for override in line_job if key_of(override) not in replaced), *own)
        for own in (_pairs(overrides) if paired else _product(overrides))
        for line in (_sweep_lines(own) if lines else [[]])
        for line_job in itertools.islice(_product(line), 1 if first_of_line else None)
    ]
    return list(dict.fromkeys(jobs))


def belongs(job: Sequence[str]) -> bool:
    """Whether a job (its overrides) is one of its experiment, be it at another scale or with more seeds."""
    return setting(job) in _settings(experiment_of(job))


def experiment_of(job: Sequence[str]) -> str:
    """The name of the experiment that a job takes its settings from; "" for none."""
    return next((o.removeprefix(EXPERIMENT) for o in job if o.startswith(EXPERIMENT)), "")


def setting(job: Sequence[str]) -> frozenset[str]:
    """The overrides of a job that tell its setting, its experiment apart."""
    return frozenset(o for o in job if key_of(o) not in SAME_SETTING and not o.startswith(EXPERIMENT))


def explicit(job: Sequence[str]) -> list[str]:
    """What a command line gives of the keys that a scale cuts; before `experiment=` are the lines of its file."""
    named = [number for number, override in enumerate(job) if override.startswith(EXPERIMENT)]
    given = {key_of(override) for override in job[named[0] if named else 0 :]}
    return [key for key in CUT_BY_SCALE if key in given]


@cache
def _settings(experiment: str) -> frozenset[frozenset[str]]:
    return frozenset(setting(job) for job in expand([EXPERIMENT + experiment])) if experiment else frozenset()


def key_of(override: str) -> str:
    """The key of an override, without signs before it."""
    return override.lstrip("+~").partition("=")[0]


def renamed(override: str) -> str:
    """`experiment=NAME` and `+experiment=NAME` both mean the file experiments/NAME.yaml (NAME,OTHER: each of them)."""
    override = override.removeprefix("++")  # add or change: every key that can be changed is there already
    key, _, value = override.partition("=")
    if key not in ("experiment", "+experiment", "+experiments", "+experiments@_global_"):
        return override
    if value.startswith("glob("):
        return EXPERIMENT + value
    for name in value.split(","):
        if name not in experiments():
            raise UserError(f"experiment={name}: allowed are {', '.join(experiments())}{nearest(name, experiments())}")
    return EXPERIMENT + value


def _sweep_lines(overrides: Sequence[str]) -> list[list[str]]:
    name = experiment_of(overrides)
    lines = registry.read_settings(experiment_files()[name]).get("sweep") if name else None
    return [str(line).split() for line in lines or [""]]


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


def parsed(override: str) -> "Override":
    """What Hydra's grammar makes of an override; UserError where it makes nothing."""
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException

    try:
        return OverridesParser.create().parse_override(override)
    except HydraException as error:
        raise UserError(
            f"{override}: not understood ({first_lines(error)}); write key=value or key=a,b, and a text with other "
            """letters in two kinds of quotes: 'key="a text"'"""
        ) from None


def _values(override: str) -> list[str]:
    if re.fullmatch(r"\w+([./]\w+)*=[\w.-]+", override):  # a word or a number, whose value no grammar changes
        return [override]
    from hydra.core.override_parser.types import Glob

    one = parsed(override)
    if not one.is_sweep_override():
        return [override]
    key = override.partition("=")[0]
    if one.is_interval_sweep():
        raise UserError(f"{override}: an interval is for a search (hydra/sweeper=optuna); list values, or range(1,5)")
    if isinstance(pattern := one.value(), Glob):
        names = experiments() if key == EXPERIMENT[:-1] else registry.groups().get(key, [])
        if not (chosen := pattern.filter(names)):
            allowed = f"allowed are {', '.join(names)}" if names else "glob is for groups and experiments"
            raise UserError(f"{override}: fits nothing; {allowed}")
        return [f"{key}={name}" for name in chosen]
    return [f"{key}={value}" for value in one.sweep_string_iterator()]


def refuse_options(words: Sequence[str]) -> None:
    """UserError for an option of Hydra's own command line, with what takes its place (conf/renamed.yaml)."""
    listed = registry.read_settings(CONF / "renamed.yaml")["hydra_options"]
    instead = {option: text for options, text in listed.items() for option in options.split()}
    for option in (word.partition("=")[0] for word in words):
        if option in instead:
            raise UserError(f"{option} is an option of Hydra that is not needed here: {instead[option]}")


def _refuse_renamed(override: str) -> None:
    """UserError for a name of version 0.1 or a setting of Hydra, with what takes its place (conf/renamed.yaml)."""
    renamed = registry.read_settings(CONF / "renamed.yaml")
    key, _, value = override.lstrip("+~").partition("=")
    for start, instead in renamed["hydra_settings"].items():
        if key.startswith(start):
            raise UserError(f"{override}: {instead}")
    for old, new in renamed["keys"].items():
        if key == old or key.startswith(f"{old}."):
            raise UserError(f"{override}: {old} is called {new} now; write {override.replace(old, new, 1)}")
    for chosen in (f"{key}={word}" for word in value.split(",")):
        if chosen in renamed["options"]:
            raise UserError(f"{override}: {chosen} is called {key}={renamed['options'][chosen]} now")


def check(overrides: Sequence[str]) -> None:
    """UserError for a misspelt group or option: Hydra's own advice, to append with +, would mislead.

    Keys of a group are checked with their values, by the types that take them.
    """
    groups = registry.groups()
    top = sorted({*groups, "chain", "device", "seeds", "record", "whole_chain", "hydra", "experiment"})
    earlier: dict[str, str] = {}
    for override in overrides:
        _refuse_renamed(override)
        key, _, value = override.lstrip("+~").partition("=")
        if key in earlier:
            raise UserError(f"{key} is given twice: {earlier[key]} and {override}; give it once")
        earlier[key] = override
        head = "experiment" if override.startswith(EXPERIMENT) else re.split(r"[./@]", key)[0]
        if head not in top:
            raise UserError(f"{override}: unknown key {head!r}{nearest(head, top)}; allowed are {', '.join(top)}")
        if key in groups and value not in groups[key] and not override.startswith("~"):
            raise UserError(f"{override}: allowed are {', '.join(groups[key])}{nearest(value, groups[key])}")
        if override.startswith("~") and "." in key:
            raise UserError(f"{override}: keys cannot be removed; give another value")
        if override.startswith("~") and key in groups:
            instead = f"write {key}=none" if "none" in groups[key] else f"choose one of {', '.join(groups[key])}"
            raise UserError(f"{override}: a group cannot be removed; {instead}")
        if override.startswith("+") and "." in key:
            raise UserError(f"{override}: keys cannot be added; leave out the + and use a key that the schema has")


def first_lines(error: Exception) -> str:
    """The useful part of what Hydra says, on one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    useful = [line for line in lines if not line.startswith(("full_key", "object_type", "reference_type", "To append"))]
    return "; ".join(useful[:3])
