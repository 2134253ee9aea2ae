"""The stored runs as result tables, and what a paper's folder says of them."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, field
from pathlib import Path
from typing import Any, Self

from pydantic import TypeAdapter
from pydantic.dataclasses import dataclass as checked

from repro.errors import UserError
from repro.results.columns import Settings
from repro.results.results import Results, read_table, typed
from repro.results.stored import BENCH_FILE, Stored, StoredRun, read_record
from repro.results.table_schema import TABLES, Cell
from repro.tracking.files import read_yaml
from repro.tracking.lazy_pandas import pd
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import digest
from repro.tracking.record import Record

FILES = ("as_printed.yaml", "motions.yaml")
# Figures show no more; results stay small enough to commit.
CURVE_STEPS, CURVE_BITS = 200, 20
TRAJECTORY_POINTS = 300
TRAJECTORY_MEMBERS = 3
REMEDY = "delete its folder and run again"
UPSTREAM_KINDS = ("data", "fits", "control")


@checked(frozen=True)
class Gathering:
    """How runs are gathered for one paper; settings are by dotted key."""

    protocols: Mapping[str, Settings] = field(default_factory=dict)  # what counts as printed, by name
    trajectories: Mapping[str, Settings] = field(
        default_factory=dict
    )  # experiments and settings of which they are kept
    closed_loops: tuple[str, ...] = ()  # experiments of whose closed loops the first of each run is kept

    @classmethod
    def load(cls, paper: Path) -> Self:
        """Read as_printed.yaml and motions.yaml of a paper, where they exist. Raises UserError for a damaged file."""
        try:
            content = [read_yaml(paper / name) for name in FILES if (paper / name).is_file()]
            return TypeAdapter(cls).validate_python({key: value for each in content for key, value in each.items()})
        except (AttributeError, ValueError) as error:
            message = f"{' and '.join(FILES)} in {paper} must hold mappings and lists of names: {error}"
            raise UserError(message) from error

    def is_as_printed(self, settings: Settings) -> bool:
        """Whether a run of these settings, at its scale, follows a protocol; what that does not name is free."""
        return any(printed.items() <= settings.items() for printed in self.protocols.values())

    def keeps_trajectories(self, experiment: str, settings: Settings) -> bool:
        """Whether the trajectories of a run are kept."""
        return experiment in self.trajectories and self.trajectories[experiment].items() <= settings.items()


NO_PAPER = Gathering()


def gather(stored: Stored, paper: Gathering = NO_PAPER) -> Results:
    """Read the tables of stored runs and benches, as `paper` says. Raises UserError naming a damaged file."""
    cards = {(run.id, run.experiment): _card(run, paper) for run in stored.runs}
    finished = [run for run in stored.runs if run.outcome == "ok"]
    distinct = {run.id: run for run in finished}.values()  # once, though several experiments list it
    moved = {run.id: run for run in finished if paper.keeps_trajectories(run.experiment, run.card.settings)}.values()
    driven = {run.id: run for run in finished if run.experiment in paper.closed_loops}.values()
    all_loops = (_table(run, "closed_loops") for run in driven)
    known: dict[str, Record | None] = {}
    rows = {
        "metrics": [_beside(_table(run, "metrics"), cards[run.id, run.experiment]) for run in finished],
        "curves": [curve for run in distinct for curve in _thinned(_table(run, "curves"))],
        "trajectories": [_first_points(_table(run, "trajectories")) for run in moved],
        "identifiability": [_table(run, "identifiability") for run in distinct],
        "control": [_loops(run) for run in finished],
        "closed_loops": [loops[loops["loop"] == loops["loop"].min()] for loops in all_loops],
        "bench": [
            read_table(bench.path(BENCH_FILE), REMEDY).assign(run=bench.id, command=bench.provenance.command)
            for bench in stored.benches
        ],
    }
    return Results(
        runs=typed("runs", [_run_row(run, cards[run.id, run.experiment]) for run in stored.runs]),
        stages=typed("stages", [row for run in distinct for row in _stages_of(run, known)]),
        cases=typed("cases", map(asdict, stored.cases)),
        **{name: typed(name, _together(tables)) for name, tables in rows.items()},  # type: ignore[arg-type]
    )


def _card(run: StoredRun, paper: Gathering) -> dict[str, Cell]:
    """The columns that place and describe a run."""
    try:
        settings, described = run.card.settings, run.card.run_columns()
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        message = f"{run.folder / RUN_FILE} has a run card of the wrong type ({error}); delete the folder, run again"
        raise UserError(message) from error
    place: dict[str, Cell] = {"run": run.id, "experiment": run.experiment, "scale": run.scale}
    name = digest(settings)[:10] if settings else ""
    return {**place, "setting": name, **described, "as_printed": paper.is_as_printed(settings)}


def _loops(run: StoredRun) -> "pd.DataFrame":
    """Closed loops with what the card says of their model, controller and task."""
    place = {"experiment": run.experiment, "scale": run.scale}
    return _beside(_table(run, "control"), place | run.card.loop_columns())


def _run_row(run: StoredRun, card: Mapping[str, Cell]) -> dict[str, object]:
    return {
        **card,
        "config": json.dumps(dict(run.card.settings), sort_keys=True),
        "changed": " ".join(sorted(run.card.changed)),
        **{name: getattr(run, name) for name in ("outcome", "error", "stale")},
        "seeds": list(run.card.seeds),
        "member_status": list(run.card.member_status),
        "command": run.listed.command,
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
            known[id] = next((read_record(folder) for folder in folders if (folder / RUN_FILE).is_file()), None)
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
        **{name: getattr(origin, name) for name in ("started", "wall_s", "cpu_s", "peak_memory_mib")},
        **{name: origin.git.get(name) for name in ("commit", "clean")},
        "python": machine.get("python"),
        # The first word of Linux-6.1-x86_64 says enough.
        "system": (machine.get("platform") or "").partition("-")[0],
        "processor": machine.get("processor"),
        "cores": machine.get("cores_allowed"),
        "libraries": json.dumps(record.identity.libraries, sort_keys=True),
        "config": json.dumps(record.identity.config, sort_keys=True),
    }


def _table(run: StoredRun, name: str) -> "pd.DataFrame":
    path = run.folder / f"{name}.parquet"
    # A fit without steps, such as least squares, leaves its curves empty.
    if not path.is_file() or path.stat().st_size == 0:
        return pd.DataFrame(columns=[*TABLES[name]])
    return read_table(path, REMEDY).assign(run=run.id)


def _beside(table: "pd.DataFrame", cells: Mapping[str, Cell]) -> "pd.DataFrame":
    """A table with further columns, each of one value: at once, which takes a fraction of the time of `assign`."""
    import pandas as pd

    columns: dict[str, Any] = {str(name): table[name] for name in table}
    return pd.DataFrame(columns | dict(cells), index=table.index)


def _thinned(curves: "pd.DataFrame") -> Iterator["pd.DataFrame"]:
    """Each quantity at steps of its own, since not all are recorded equally often; values with six digits."""
    import numpy as np

    for _, curve in curves.groupby("name", sort=False):
        steps = np.sort(curve["step"].unique())
        kept = np.linspace(0, len(steps) - 1, min(CURVE_STEPS, len(steps))).round().astype(int)
        shown = curve[curve["step"].isin(steps[kept])]
        mantissa, exponent = np.frexp(shown["value"])
        yield shown.assign(value=np.ldexp(np.round(np.ldexp(mantissa, CURVE_BITS)), exponent - CURVE_BITS))


def _first_points(trajectories: "pd.DataFrame") -> "pd.DataFrame":
    members = sorted(trajectories["member"].unique())[:TRAJECTORY_MEMBERS]
    shown = trajectories[trajectories["member"].isin(members)]
    free = shown[shown["name"].str.startswith("free.")]  # a long motion of its own, thinned already
    first = shown.groupby(["member", "name"], sort=False).head(TRAJECTORY_POINTS)
    retained: pd.DataFrame = free[free["member"] == members[0]] if len(free) else first
    return retained


def _together(tables: Sequence["pd.DataFrame"]) -> "pd.DataFrame":
    filled = [table for table in tables if not table.empty]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame()
