"""What the store holds, read light: run.json and the experiments' lists, no table library."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.results.run_card import RunCard

Staleness = Callable[[Mapping[str, Any]], bool]


@dataclass(frozen=True)
class StoredRun:
    """One run as one experiment lists it; `record` is its run.json, of the last failed attempt where there is no other.

    `listed` is the entry of the list, which describes a run that did not finish too.
    """

    id: str
    experiment: str
    scale: str
    folder: Path
    record: Mapping[str, Any]
    listed: Mapping[str, Any]
    command: str
    error: str
    stale: bool

    @property
    def outcome(self) -> str:
        """`ok`, `failed` or `missing`."""
        return str(self.record.get("outcome", "missing"))

    @property
    def summary(self) -> Mapping[str, Any]:
        """What run.json holds of the run and its results."""
        return self.record.get("summary") or {}

    @cached_property
    def card(self) -> RunCard:
        """The run card; empty where nothing describes the run. Raises TypeError or ValueError for a wrong one."""
        return RunCard.of(self.summary if self.outcome == "ok" else self.listed)


def never_stale(_record: Mapping[str, Any]) -> bool:
    """Take every run as made by the present code: the default where staleness is not checked."""
    return False


def stored_runs(outputs: Path, scale: str, stale: Staleness = never_stale) -> list[StoredRun]:
    """List the runs of a scale's experiments; one of several experiments comes once for each.

    Raises UserError for a damaged file.
    """
    return [
        _stored(outputs, job, path.stem, scale, stale)
        for path in sorted((outputs / "experiments" / scale).glob("*.json"))
        for job in jobs_of(path)
        if not (outputs / "bench" / str(job.get("run"))).is_dir()
    ]


def stored_benches(outputs: Path, scale: str) -> list[Path]:
    """List the bench folders of a scale's experiments; every bench folder where no experiment lists any."""
    listed = {str(job.get("run")) for path in (outputs / "experiments" / scale).glob("*.json") for job in jobs_of(path)}
    finished = [
        path.parent
        for path in sorted((outputs / "bench").glob("*/run.json"))
        if read_json(path).get("outcome") == "ok" and (path.parent / "bench.parquet").is_file()
    ]
    return [folder for folder in finished if folder.name in listed] or finished


def jobs_of(path: Path) -> list[dict[str, Any]]:
    """Read the jobs that an experiment's list names."""
    jobs = read_json(path).get("jobs")
    if not isinstance(jobs, list):
        message = f"{path} has no list of jobs; delete it and run the experiment again"
        raise UserError(message)
    return jobs


def read_json(path: Path) -> dict[str, Any]:
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


def _stored(outputs: Path, job: Mapping[str, Any], experiment: str, scale: str, stale: Staleness) -> StoredRun:
    name = str(job.get("run") or "")
    finished, failed = outputs / "runs" / name, outputs / "runs" / ".failed" / name
    folder = failed if name and not finished.is_dir() and failed.is_dir() else finished
    record = read_json(folder / "run.json") if name and (folder / "run.json").is_file() else {}
    error = record.get("error") or job.get("error") or {}
    message = f"{error.get('type', 'error')}: {error.get('message', '')}" if isinstance(error, dict) else str(error)
    return StoredRun(
        id=name,
        experiment=experiment,
        scale=scale,
        folder=folder,
        record=record,
        listed=job,
        command=str(job.get("command") or (record.get("provenance") or {}).get("command") or ""),
        error=message if error else "",
        stale=bool(record) and stale(record),
    )
