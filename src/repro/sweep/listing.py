"""Which runs belong to which experiment: outputs/experiments/<scale>/<experiment>.json."""

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from repro.config.compose import compose
from repro.config.overrides import EXPERIMENT, belongs
from repro.config.places import digest
from repro.errors import UserError
from repro.sweep.planned_job import Planned
from repro.tracking.files import disk_errors_explained, write_json
from repro.tracking.paths import Paths


def list_jobs(paths: Paths, jobs: Sequence[Planned]) -> None:
    """List the jobs under their experiments, before any of them runs, so that a missing run is seen as missing.

    A job that its experiment does not ask for (another setting) is not listed. What was listed before stays as long as
    the experiment asks for it, more seeds included.
    """
    chosen: dict[Path, list[Planned]] = {}
    for job in jobs:
        config, overrides = job.composed.config, job.composed.overrides
        if config.experiment is not None and belongs(overrides):
            chosen.setdefault(paths.experiments / config.scale.name / f"{config.experiment}.json", []).append(job)
    with disk_errors_explained(paths.root):
        for path, listed in chosen.items():
            _write(path, listed)


def _write(path: Path, jobs: Sequence[Planned]) -> None:
    before = _read(path)
    new = {frozenset(job.composed.overrides): _entry(job) for job in jobs}
    kept = {key: entry for key, entry in _still_asked_for(before, path.stem) if key not in new}
    content = {
        "experiment": path.stem,
        "scale": path.parent.name,
        "settings": digest(path.stem),
        "jobs": [*new.values(), *kept.values()],
    }
    if content != before:
        write_json(path, content)


def _still_asked_for(before: dict[str, Any], experiment: str) -> Iterator[tuple[frozenset[str], dict[str, Any]]]:
    same = before.get("settings") == digest(experiment)
    for entry in before.get("jobs", []):
        overrides = entry["overrides"]
        if EXPERIMENT + experiment in overrides and belongs(overrides):
            # An error here is for the one who runs this job, not for who runs others.
            with suppress(UserError):
                yield frozenset(overrides), entry if same else _entry(Planned.of(compose(overrides)))


def _entry(job: Planned) -> dict[str, Any]:
    return {"overrides": list(job.composed.overrides), "run": job.run, "command": job.composed.command}


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_bytes())
        return content if isinstance(content, dict) else {}
    except (OSError, ValueError):
        return {}
