"""From overrides to checked configurations, by Hydra; what was composed before is read from a file."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.config.composition import composed, typed
from repro.config.overrides import EXPERIMENT, check, experiment_of, renamed
from repro.config.places import code_digest, digest
from repro.config.rules import impossible
from repro.config.schema import Config
from repro.data.data_options import RecordingFile
from repro.errors import UserError
from repro.tracking.cache import Cache

Overrides = tuple[str, ...]  # of one job


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
    names = {job: experiment_of(job) for job in jobs}
    known = {name: _known(cache, name) for name in set(names.values())}
    stored = {job: known[name].values.get(" ".join(job)) for job, name in names.items()}
    configs = {job: Config.model_validate(values) for job, values in stored.items() if values is not None}
    unknown = [job for job in names if job not in configs]
    for job in unknown:
        check(job)
    if unknown:
        on_unknown(unknown)
    for job in unknown:
        raw, name = composed(job), names[job]
        if (raw["experiment"] or "") != name:
            raise UserError(f"experiments/{name}.yaml: experiment = {raw['experiment']!r}: must be {name!r}")
        config = configs[job] = parse(raw)
        if not isinstance(config.data, RecordingFile):  # which is checked each time, as the file is
            known[name].values[" ".join(job)] = config.model_dump(mode="json")
    for accepted in known.values():
        accepted.save()
    return [Composed(job, configs[job]) for job in jobs]


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


def _known(folder: Path | None, experiment: str) -> Cache:
    """What was accepted of an experiment ("": of single runs) under these settings and this code, by the overrides."""
    file = None if folder is None else folder / f"{experiment or 'single'}.sqlite"
    return Cache(file, [digest(experiment), code_digest()])
