"""What the store holds, read light: run.json and the experiments' lists, no table library."""

import json
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from repro.errors import UserError
from repro.results.run_card import RunCard
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import Json
from repro.tracking.record import Record


@dataclass(frozen=True)
class StoredRun:
    """One run as one experiment lists it.

    folder   where it is stored, or its last failed attempt, or would be
    content  its run.json; empty where there is none
    listed   its entry in the list of the experiment
    """

    id: str
    experiment: str
    scale: str
    folder: Path
    content: Json
    listed: Json
    stale: bool

    @cached_property
    def record(self) -> Record | None:
        """Its run.json. Raises UserError naming a file that holds something else."""
        return record_of(self.folder, self.content) if self.content else None

    @property
    def outcome(self) -> str:
        """`ok`, `failed` or `missing`."""
        return "missing" if self.record is None else self.record.outcome

    @property
    def error(self) -> str:
        """Why it failed; empty where it did not."""
        failure = None if self.record is None else self.record.failure
        return "" if failure is None else f"{failure.type}: {failure.message}"

    @property
    def command(self) -> str:
        """The command line that repeats it."""
        made_by = "" if self.record is None else self.record.provenance.command
        return str(self.listed.get("command") or made_by)

    @cached_property
    def card(self) -> RunCard:
        """The run card; of a run that did not finish, as listed. Raises TypeError or ValueError for a wrong one."""
        return RunCard.of(self.listed if self.record is None or self.outcome != "ok" else self.record.summary)


def stored_runs(outputs: Path, scale: str, stale: Collection[str] = ()) -> list[StoredRun]:
    """List the runs of a scale's experiments; one of several experiments comes once for each.

    stale  ids of runs that are older than the code

    Raises UserError for a damaged file.
    """
    return [
        _stored(outputs, job, experiment, scale, stale)
        for experiment, job in _listed(outputs, scale)
        if not (outputs / "bench" / str(job.get("run"))).is_dir()
    ]


def stored_benches(outputs: Path, scale: str) -> list[Path]:
    """List the bench folders of a scale's experiments; every bench folder where no experiment lists any."""
    listed = {str(job.get("run")) for _, job in _listed(outputs, scale)}
    finished = [
        path.parent
        for path in sorted((outputs / "bench").glob("*/run.json"))
        if read_json(path).get("outcome") == "ok" and (path.parent / "bench.parquet").is_file()
    ]
    return [folder for folder in finished if folder.name in listed] or finished


def _listed(outputs: Path, scale: str) -> Iterator[tuple[str, Json]]:
    """The jobs that the lists of a scale's experiments name, each with its experiment."""
    for path in sorted((outputs / "experiments" / scale).glob("[!.]*.json")):
        jobs = read_json(path).get("jobs")
        if not isinstance(jobs, list):
            raise UserError(f"{path} has no list of jobs; delete it and run the experiment again")
        yield from ((path.stem, job) for job in jobs)


def record_of(folder: Path, content: Json) -> Record:
    """Read the content of a run.json. Raises UserError naming the file when it is something else."""
    try:
        return Record.of(folder, content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        message = f"{folder / RUN_FILE} is no record of a stage ({error!r}); delete its folder and run again"
        raise UserError(message) from error


def read_json(path: Path) -> Json:
    """Read one JSON object. Raises UserError naming the file when it is damaged."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = f"{path} cannot be read ({error}); delete its folder and run again"
        raise UserError(message) from error
    if not isinstance(content, dict):
        message = f"{path} holds no JSON object; delete its folder and run again"
        raise UserError(message)
    return content


def stale_runs(outputs: Path) -> set[str]:
    """Survey the store, and return the ids of the runs that are older than the code that would make them now."""
    from repro.tracking.survey import survey

    return {item.id for item in survey(Paths(outputs)) if item.state == "stale"}


def _stored(outputs: Path, job: Json, experiment: str, scale: str, stale: Collection[str]) -> StoredRun:
    name = str(job.get("run") or "")
    finished, failed = outputs / "runs" / name, outputs / "runs" / ".failed" / name
    folder = failed if name and not finished.is_dir() and failed.is_dir() else finished
    content = read_json(folder / RUN_FILE) if name and (folder / RUN_FILE).is_file() else {}
    return StoredRun(name, experiment, scale, folder, content, job, stale=bool(content) and name in stale)
