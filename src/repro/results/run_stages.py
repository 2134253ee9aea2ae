"""Where a run comes from: its stages, each with its configuration, code, machine and cost."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from repro.results.stored import StoredRun, read_json
from repro.tracking.paths import RUN_FILE, Paths

if TYPE_CHECKING:
    from pathlib import Path

UPSTREAM_KINDS = ("data", "fits", "control")


def stages_of(run: StoredRun, known: dict[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row a stage of a finished run, upstream first; `known` keeps what several runs share.

    Raises UserError naming a damaged file.
    """
    paths = Paths(run.folder.parents[1])
    rows = {record["id"]: _row(run.id, name, record) for name, record in _upstream(run.record, paths, known)}
    return [*rows.values(), _row(run.id, "evaluation", run.record)]


def _upstream(
    record: Mapping[str, Any], paths: Paths, known: dict[str, Mapping[str, Any]]
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Walk what a stage was made from, sources first; a stage that is no longer stored is left out."""
    for name, id in ((record.get("identity") or {}).get("upstream") or {}).items():
        if id not in known:
            file = _file(paths, id)
            known[id] = read_json(file) if file is not None else {}
        if known[id]:
            yield from _upstream(known[id], paths, known)
            yield name, known[id]


def _file(paths: Paths, id: str) -> "Path | None":
    files = (paths.folder(kind, id) / RUN_FILE for kind in UPSTREAM_KINDS)
    return next((file for file in files if file.is_file()), None)


def _row(run: str, name: str, record: Mapping[str, Any]) -> dict[str, Any]:
    origin, identity = record.get("provenance") or {}, record.get("identity") or {}
    source, machine = origin.get("git") or {}, origin.get("machine") or {}
    return {
        "run": run,
        "stage": name,
        "id": record["id"],
        "started": origin.get("started"),
        "wall_s": origin.get("wall_s"),
        "cpu_s": origin.get("cpu_s"),
        "peak_memory_mib": origin.get("peak_memory_mib"),
        "commit": source.get("commit"),
        "clean": source.get("clean"),
        "python": machine.get("python"),
        # Linux-6.1-x86_64 says more than anybody can use.
        "system": (machine.get("platform") or "").partition("-")[0],
        "processor": machine.get("processor"),
        "cores": machine.get("cores_allowed"),
        "libraries": json.dumps(identity.get("libraries") or {}, sort_keys=True),
        "config": json.dumps(identity.get("config") or {}, sort_keys=True),
    }
