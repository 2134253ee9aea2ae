"""Which runs belong to which experiment: outputs/experiments/<scale>/<experiment>.json, read by report and status."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Self

from repro.config.compose import compose
from repro.config.overrides import EXPERIMENT, belongs
from repro.config.places import digest
from repro.errors import UserError
from repro.pipeline.card import card_of
from repro.results.results import Case
from repro.sweep.planned_job import PlannedJob
from repro.tracking.files import disk_errors_explained, write_json
from repro.tracking.paths import Paths


@dataclass(frozen=True)
class ListedJob:
    """One job of an experiment: its overrides, the id of its run, and the command line that repeats it.

    `settings` and `changed`, as on the run card, describe a run that was not finished when it was listed.
    """

    overrides: Sequence[str]
    run: str
    command: str
    settings: Mapping[str, object] = field(default_factory=dict)
    changed: Sequence[str] = field(default_factory=list)

    @classmethod
    def of(cls, job: PlannedJob) -> Self:
        """The entry of a planned job."""
        known = (list(job.composed.overrides), job.run, job.composed.command)
        if job.record is not None:
            return cls(*known)
        card = card_of(job.pipeline.config)
        return cls(*known, dict(card.settings), sorted(card.changed))


@dataclass(frozen=True)
class ExperimentList:
    """All jobs of one experiment; `settings` is the digest of the settings that the ids of the runs follow from.

    `cases`, of sensitivity runs alone, say which run takes the place of which.
    """

    experiment: str
    scale: str
    settings: str
    jobs: Sequence[ListedJob] = ()
    cases: Sequence[Case] = ()

    @classmethod
    def read(cls, path: Path) -> Self | None:
        """The stored list, None where there is none. Raises UserError for a damaged file."""
        try:
            content = json.loads(path.read_bytes())
            jobs = [ListedJob(**job) for job in content.pop("jobs")]
            cases = [Case(**case) for case in content.pop("cases", ())]
            return cls(**content, jobs=jobs, cases=cases)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise UserError(f"{path} cannot be read ({error}); delete it and run the experiment again") from error

    def write(self, path: Path) -> None:
        """Write the list, atomically."""
        content = asdict(self)
        if not self.cases:
            del content["cases"]
        write_json(path, content)


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


def _add(path: Path, jobs: Sequence[PlannedJob]) -> None:
    before = ExperimentList.read(path)
    entries = {frozenset(job.composed.overrides): ListedJob.of(job) for job in jobs}
    if before is not None:
        entries |= {key: job for key, job in _still_belonging(before).items() if key not in entries}
    after = ExperimentList(path.stem, path.parent.name, digest(path.stem), [*entries.values()], [])
    if after != before:
        after.write(path)


def _still_belonging(before: ExperimentList) -> Mapping[frozenset[str], ListedJob]:
    """What the experiment still consists of; runs get their present ids where the settings have changed."""
    unchanged = before.settings == digest(before.experiment)
    entries = {}
    for job in before.jobs:
        if EXPERIMENT + before.experiment in job.overrides and belongs(job.overrides):
            # A setting that has become impossible concerns the command that runs it, not this one.
            with suppress(UserError):
                entries[frozenset(job.overrides)] = (
                    job if unchanged else ListedJob.of(PlannedJob.of(compose(job.overrides)))
                )
    return entries
