"""Where a run comes from: its stages, each with its configuration, code, machine and cost."""

import json
from collections.abc import Iterator

from repro.results.stored import StoredRun, read_json, record_of
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.record import Record

UPSTREAM_KINDS = ("data", "fits", "control")


def stages_of(run: StoredRun, known: dict[str, Record | None]) -> list[dict[str, object]]:
    """Return one row per stage of a finished run, upstream first; `known` holds what several runs share.

    Raises UserError naming a damaged file.
    """
    assert run.record is not None
    paths = Paths(run.folder.parents[1])
    rows = {record.id: _row(run.id, name, record) for name, record in _upstream(run.record, paths, known)}
    return [*rows.values(), _row(run.id, "evaluation", run.record)]


def _upstream(record: Record, paths: Paths, known: dict[str, Record | None]) -> Iterator[tuple[str, Record]]:
    """Walk what a stage was made from, sources first; a stage that is no longer stored is left out."""
    for name, id in record.identity.upstream.items():
        if id not in known:
            folders = [paths.folder(kind, id) for kind in UPSTREAM_KINDS]
            stored = [folder for folder in folders if (folder / RUN_FILE).is_file()]
            known[id] = record_of(stored[0], read_json(stored[0] / RUN_FILE)) if stored else None
        source = known[id]
        if source is not None:
            yield from _upstream(source, paths, known)
            yield name, source


def _row(run: str, name: str, record: Record) -> dict[str, object]:
    origin, machine = record.provenance, record.provenance.machine
    return {
        "run": run,
        "stage": name,
        "id": record.id,
        "started": origin.started,
        "wall_s": origin.wall_s,
        "cpu_s": origin.cpu_s,
        "peak_memory_mib": origin.peak_memory_mib,
        "commit": origin.git.get("commit"),
        "clean": origin.git.get("clean"),
        "python": machine.get("python"),
        # The first word of Linux-6.1-x86_64 says enough.
        "system": (machine.get("platform") or "").partition("-")[0],
        "processor": machine.get("processor"),
        "cores": machine.get("cores_allowed"),
        "libraries": json.dumps(record.identity.libraries, sort_keys=True),
        "config": json.dumps(record.identity.config, sort_keys=True),
    }
