"""Lists jobs under their experiments, where report and status find them."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from filelock import FileLock

from repro.config.compose import compose
from repro.config.overrides import EXPERIMENT, belongs
from repro.config.places import digest
from repro.errors import UserError
from repro.pipeline.card import card_of
from repro.sweep.planned_job import PlannedJob
from repro.tracking.experiment_list import ExperimentList, ListedJob
from repro.tracking.files import disk_errors_explained
from repro.tracking.paths import Paths


def list_jobs(paths: Paths, jobs: Sequence[PlannedJob]) -> None:
    """List the jobs under their experiments, before any of them runs, so that a missing run is seen as missing.

    A job that is not one of its experiment (another setting) is not listed. What was listed before stays as long as
    it belongs to the experiment, be it with more seeds. Raises UserError for a damaged list.
    """
    by_file: dict[Path, list[PlannedJob]] = {}
    for job in jobs:
        config, overrides = job.composed.config, job.composed.overrides
        if config.experiment is not None and belongs(overrides):
            by_file.setdefault(paths.experiments / config.scale.name / f"{config.experiment}.json", []).append(job)
    with disk_errors_explained(paths.root):
        for path, listed in by_file.items():
            _add(path, listed)


def listed_job(job: PlannedJob) -> ListedJob:
    """The entry of a planned job."""
    known = (list(job.composed.overrides), job.run, job.composed.command)
    if job.record is not None:
        return ListedJob(*known)
    card = card_of(job.pipeline.config)
    return ListedJob(*known, dict(card.settings), sorted(card.changed))


def _add(path: Path, jobs: Sequence[PlannedJob]) -> None:
    before, after = _extended(path, jobs)
    if after != before:
        path.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(path.with_name(f".{path.stem}.lock")):  # read again: another command may have added to it
            _extended(path, jobs)[1].write(path)


def _extended(path: Path, jobs: Sequence[PlannedJob]) -> tuple[ExperimentList | None, ExperimentList]:
    """A list as stored, None without one, and with the jobs added."""
    before = ExperimentList.read(path) if path.is_file() else None
    entries = {frozenset(job.composed.overrides): listed_job(job) for job in jobs}
    if before is not None:
        entries |= {key: job for key, job in _still_belonging(before).items() if key not in entries}
    return before, ExperimentList(path.stem, path.parent.name, digest(path.stem), [*entries.values()])


def _still_belonging(before: ExperimentList) -> Mapping[frozenset[str], ListedJob]:
    """What the experiment still consists of; runs get their present ids where the settings have changed."""
    unchanged = before.settings == digest(before.experiment)
    entries = {}
    for job in before.jobs:
        if EXPERIMENT + before.experiment in job.overrides and belongs(job.overrides):
            # A setting that has become impossible concerns the command that runs it, not this one.
            with suppress(UserError):
                entries[frozenset(job.overrides)] = (
                    job if unchanged else listed_job(PlannedJob.of(compose(job.overrides)))
                )
    return entries
