"""Walk the stored runs into the result tables."""

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from repro.errors import UserError
from repro.results.gathering import NO_PAPER, Gathering
from repro.results.results import Results, read_table, typed
from repro.results.stored import StoredRun, read_json, record_of, stored_benches, stored_runs
from repro.results.table_schema import Cell
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import digest
from repro.tracking.record import Record

if TYPE_CHECKING:
    import pandas as pd

# Figures show no more; results stay small enough to commit.
CURVE_STEPS = 400
TRAJECTORY_POINTS = 300
TRAJECTORY_MEMBERS = 3
REMEDY = "delete its folder and run again"
UPSTREAM_KINDS = ("data", "fits", "control")


def gather(outputs: Path, scale: str, *, stale: Collection[str] = (), paper: Gathering = NO_PAPER) -> Results:
    """Read every run of a scale's experiments into the result tables.

    stale  ids of runs that are older than the code
    paper  what the paper prints, and whose motions are kept

    Raises UserError naming a damaged file.
    """
    return gather_runs(stored_runs(outputs, scale, stale), stored_benches(outputs, scale), paper)


def gather_runs(runs: Sequence[StoredRun], benches: Sequence[Path], paper: Gathering = NO_PAPER) -> Results:
    """Read the tables of these runs and benches. Raises UserError naming a damaged file."""
    cards = {(run.id, run.experiment): _card(run, paper) for run in runs}
    finished = [run for run in runs if run.outcome == "ok"]
    distinct = [*{run.id: run for run in finished}.values()]  # once, though several experiments list it
    moved = {run.id: run for run in finished if paper.keeps_trajectories(run.experiment, run.card.settings)}.values()
    driven = {run.id: run for run in finished if run.experiment in paper.closed_loops}.values()
    known: dict[str, Record | None] = {}
    rows = {
        "metrics": [_table(run, "metrics").assign(**cards[run.id, run.experiment]) for run in finished],
        "curves": [_thinned(_table(run, "curves")) for run in distinct],
        "trajectories": [_first_points(_table(run, "trajectories")) for run in moved],
        "identifiability": [_table(run, "identifiability") for run in distinct],
        "control": [_loops(run) for run in finished],
        "closed_loops": [_first_loop(_table(run, "closed_loops")) for run in driven],
        "bench": [_bench(folder) for folder in benches],
    }
    return Results(
        runs=typed("runs", [_run_row(run, cards[run.id, run.experiment]) for run in runs]),
        stages=typed("stages", [row for run in distinct for row in _stages_of(run, known)]),
        **{name: typed(name, _together(tables)) for name, tables in rows.items()},  # type: ignore[arg-type]
    )


def _card(run: StoredRun, paper: Gathering) -> dict[str, Cell]:
    """The columns that place and describe a run."""
    try:
        card = run.card
        described = {**card.run_columns(), "as_printed": paper.is_as_printed(card.settings)}
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        message = f"{run.folder / 'run.json'} has a run card of the wrong type ({error}); delete the folder, run again"
        raise UserError(message) from error
    return {
        "run": run.id,
        "experiment": run.experiment,
        "scale": run.scale,
        "setting": digest(card.settings)[:10] if card.settings else "",
        **described,
    }


def _loops(run: StoredRun) -> "pd.DataFrame":
    """Closed loops with what the card says of their model, controller and task."""
    place = {"experiment": run.experiment, "scale": run.scale}
    return _table(run, "control").assign(**place, **run.card.loop_columns())


def _first_loop(loops: "pd.DataFrame") -> "pd.DataFrame":
    return loops if loops.empty else loops[loops["loop"] == loops["loop"].min()]


def _run_row(run: StoredRun, card: Mapping[str, Cell]) -> dict[str, object]:
    return {
        **card,
        "config": json.dumps(dict(run.card.settings), sort_keys=True),
        "changed": " ".join(sorted(run.card.changed)),
        "outcome": run.outcome,
        "error": run.error,
        "stale": run.stale,
        "seeds": list(run.card.seeds),
        "member_status": list(run.card.member_status),
        "command": run.command,
    }


def _stages_of(run: StoredRun, known: dict[str, Record | None]) -> list[dict[str, object]]:
    """One row per stage of a finished run, upstream first; `known` holds what several runs share."""
    assert run.record is not None
    paths = Paths(run.folder.parents[1])
    rows = {record.id: _stage_row(run.id, name, record) for name, record in _upstream(run.record, paths, known)}
    return [*rows.values(), _stage_row(run.id, "evaluation", run.record)]


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


def _stage_row(run: str, name: str, record: Record) -> dict[str, object]:
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


def _table(run: StoredRun, name: str) -> "pd.DataFrame":
    import pandas as pd

    path = run.folder / f"{name}.parquet"
    # A fit without steps, such as least squares, leaves its curves empty.
    if not path.is_file() or path.stat().st_size == 0:
        return pd.DataFrame()
    return read_table(path, REMEDY).assign(run=run.id)


def _bench(folder: Path) -> "pd.DataFrame":
    command = str((read_json(folder / "run.json").get("provenance") or {}).get("command") or "")
    return read_table(folder / "bench.parquet", REMEDY).assign(run=folder.name, command=command)


def _thinned(curves: "pd.DataFrame") -> "pd.DataFrame":
    """Each quantity at steps of its own: not all are recorded equally often."""
    if curves.empty:
        return curves
    return _together([_at_some_steps(one) for _, one in curves.groupby("name", sort=False)])


def _at_some_steps(curve: "pd.DataFrame") -> "pd.DataFrame":
    import numpy as np

    steps = np.sort(curve["step"].unique())
    if len(steps) <= CURVE_STEPS:
        return curve
    kept = steps[np.unique(np.linspace(0, len(steps) - 1, CURVE_STEPS).round().astype(int))]
    return curve[curve["step"].isin(kept)]


def _first_points(trajectories: "pd.DataFrame") -> "pd.DataFrame":
    if trajectories.empty:
        return trajectories
    members = sorted(trajectories["member"].unique())[:TRAJECTORY_MEMBERS]
    shown = trajectories[trajectories["member"].isin(members)]
    free = shown[shown["name"].str.startswith("free.")]  # a long motion of its own, thinned already
    first = shown.groupby(["member", "name"], sort=False).head(TRAJECTORY_POINTS)
    retained: pd.DataFrame = free[free["member"] == members[0]] if len(free) else first
    return retained


def _together(tables: Sequence["pd.DataFrame"]) -> "pd.DataFrame":
    import pandas as pd

    filled = [table for table in tables if not table.empty]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame()
