"""From overrides to checked configurations, by Hydra; what was composed before is read from a file."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.config.composed_cache import Cache
from repro.config.composition import choices, composed, typed
from repro.config.overrides import EXPERIMENT, check, experiment_of, renamed
from repro.config.rules import impossible
from repro.config.schema import Config
from repro.errors import UserError

Overrides = tuple[str, ...]  # of one job
FEW = 3  # combinations of options up to which each is composed as a whole


@dataclass(frozen=True)
class Composed:
    """One job of a sweep: its overrides, and the configuration that they make."""

    overrides: tuple[str, ...]
    config: Config

    @property
    def command(self) -> str:
        """The command line that repeats it."""
        shown = (override.replace(EXPERIMENT, "experiment=") for override in self.overrides)
        return shlex.join(["repro", "run", *shown])


def plan(
    jobs: Sequence[Overrides],
    cache: Path | None = None,
    on_unknown: Callable[[list[Overrides]], None] = lambda jobs: None,
) -> list[Composed]:
    """All jobs (the overrides of each), composed and checked before any of them runs; UserError for the first mistake.

    cache       a folder that keeps what was composed and checked, so that a known job costs nothing
    on_unknown  takes the jobs that are not known, where there are any, before the first of them is composed
    """
    caches = {name: Cache.of(cache, name) for name in dict.fromkeys(experiment_of(job) for job in jobs)}
    checked = {job: caches[experiment_of(job)].checked(job) for job in jobs}
    unknown = [job for job in checked if checked[job] is None]
    for job in unknown:
        check(job)
    if unknown:
        on_unknown(unknown)
    apart = len({choices(job) for job in unknown}) > FEW
    for job in unknown:
        raw, name = composed(job, apart=apart), experiment_of(job)
        if (raw["experiment"] or "") != name:
            raise UserError(f"experiments/{name}.yaml: experiment = {raw['experiment']!r}: must be {name!r}")
        accepted = checked[job] = parse(raw)
        caches[name].keep(job, accepted)
    for one in caches.values():
        one.save()
    return [Composed(job, config) for job in jobs if (config := checked[job]) is not None]


def compose(overrides: Sequence[str], cache: Path | None = None) -> Composed:
    """One configuration; UserError names key, value and what is allowed."""
    (composed,) = plan([tuple(renamed(override) for override in overrides)], cache)
    return composed


def parse(raw: Mapping[str, Any]) -> Config:
    """Check a composed configuration; UserError with one line per mistake: key, value, and what is allowed."""
    config = typed(raw)
    if problems := [*impossible(config)]:
        raise UserError("\n".join(problems))
    return config
