"""What the store holds of a scale, read light: the experiments' lists and run.json, no table library."""

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from repro.errors import UserError
from repro.results.run_card import RunCard
from repro.tracking.experiment_list import Case, ListedJob, experiment_lists
from repro.tracking.paths import FAILED, RUN_FILE, Paths
from repro.tracking.record import Record

BENCH_FILE = "bench.parquet"


@dataclass(frozen=True)
class StoredRun:
    """One run as one experiment lists it; `folder`: where it is stored, or its last failed attempt, or would be."""

    experiment: str
    scale: str
    listed: ListedJob
    folder: Path
    record: Record | None
    stale: bool

    @property
    def id(self) -> str:
        """The id of the run; empty for a job that has not reached it."""
        return self.listed.run

    @property
    def outcome(self) -> str:
        """`ok`, `failed` or `missing`."""
        return "missing" if self.record is None else self.record.outcome

    @property
    def error(self) -> str:
        """Why it failed; empty where it did not."""
        failure = None if self.record is None else self.record.failure
        return "" if failure is None else f"{failure.type}: {failure.message}"

    @cached_property
    def card(self) -> RunCard:
        """The run card; of a run that did not finish, as listed. Raises TypeError or ValueError for a wrong one."""
        return RunCard.of(self.record.summary if self.record and self.record.failure is None else vars(self.listed))


@dataclass(frozen=True)
class Stored:
    """What the experiments of a scale list."""

    runs: Sequence[StoredRun]  # one of several experiments once for each
    benches: Sequence[Record]  # all that there are where no experiment lists any
    cases: Sequence[Case]  # of sensitivity runs


def read_stored(outputs: Path, scale: str, stale: Collection[str] = ()) -> Stored:
    """Read what a scale's experiments list; stale: ids of runs older than the code. UserError for a damaged file."""
    paths, lists = Paths(outputs), [*experiment_lists(Paths(outputs), scale)]
    timed = [read_record(path.parent) for path in sorted((outputs / "bench").glob(f"*/{RUN_FILE}"))]
    timed = [bench for bench in timed if bench.outcome == "ok" and bench.path(BENCH_FILE).is_file()]
    listed = {job.run for each in lists for job in each.jobs}
    runs = []
    for each in lists:
        for job in each.jobs:
            folder, failed = paths.folder("runs", job.run), paths.folder("runs", job.run, FAILED)
            folder = failed if failed.is_dir() and not folder.is_dir() else folder
            record = read_record(folder) if (folder / RUN_FILE).is_file() else None
            old = record is not None and job.run in stale
            if not paths.folder("bench", job.run).is_dir():
                runs.append(StoredRun(each.experiment, scale, job, folder, record, old))
    benches = [bench for bench in timed if bench.id in listed] or timed
    return Stored(runs, benches, [case for each in lists for case in each.cases])


def read_record(folder: Path) -> Record:
    """Read a run.json without a look at the other files. Raises UserError naming a damaged one."""
    try:
        return Record.of(folder, json.loads((folder / RUN_FILE).read_bytes()))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{folder / RUN_FILE} cannot be read ({error!r}); delete its folder and run again") from error


def stale_runs(outputs: Path) -> set[str]:
    """Survey the store, and return the ids of the runs that are older than the code that would make them now."""
    from repro.tracking.survey import survey

    return {item.id for item in survey(Paths(outputs)) if item.state == "stale"}
