"""Walk the stored runs into the result tables."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.errors import UserError
from repro.results.results import Results, typed
from repro.results.run_stages import stages_of
from repro.results.schema import CARD, CONTROL, NOT_CHOSEN, as_card_value
from repro.results.stored import Staleness, StoredRun, never_stale, read_json, stored_benches, stored_runs

if TYPE_CHECKING:
    import pandas as pd

# Figures show no more; results stay small enough to commit.
CURVE_STEPS = 400
TRAJECTORY_POINTS = 300
TRAJECTORY_MEMBERS = 3
TRAJECTORIES_OF = ("sip_regimes", "ph_passivity")
CLOSED_LOOPS_OF = ("sip_control", "dip_control")


def gather(outputs: Path, scale: str, *, stale: Staleness = never_stale) -> Results:
    """Read every run of a scale's experiments into the result tables.

    `stale` judges a run.json against the present code. Raises UserError naming a damaged file.
    """
    return gather_runs(stored_runs(outputs, scale, stale), stored_benches(outputs, scale))


def gather_runs(runs: Sequence[StoredRun], benches: Sequence[Path]) -> Results:
    """Read the tables of these runs and benches. Raises UserError naming a damaged file."""
    import pandas as pd

    finished = [run for run in runs if run.outcome == "ok"]
    curves = [_thinned(_table(run, "curves")) for run in _distinct(finished)]
    drawn = {run.id: run for run in finished if run.experiment in TRAJECTORIES_OF}
    trajectories = [_first_points(_table(run, "trajectories")) for run in drawn.values()]
    return Results(
        metrics=typed("metrics", _together([_metrics(run) for run in finished])),
        runs=typed("runs", [_run_row(run) for run in runs]),
        curves=typed("curves", _together(curves)),
        trajectories=typed("trajectories", _together(trajectories)),
        identifiability=typed(
            "identifiability", _together([_table(run, "identifiability") for run in _distinct(finished)])
        ),
        control=typed("control", _together([_loops(run) for run in finished])),
        closed_loops=typed("closed_loops", _together([_first_loop(run) for run in _distinct(finished)])),
        stages=typed("stages", _stages(finished)),
        bench=typed("bench", _together([_bench(folder) for folder in benches]) if benches else pd.DataFrame()),
    )


def _distinct(runs: Sequence[StoredRun]) -> list[StoredRun]:
    """Each run once, though several experiments list it."""
    return [*{run.id: run for run in runs}.values()]


def _metrics(run: StoredRun) -> "pd.DataFrame":
    table = _table(run, "metrics")
    for column, value in {**_place(run), **_card(run)}.items():
        table[column] = value
    return table


def _loops(run: StoredRun) -> "pd.DataFrame":
    """Closed loops with what the card says of their model."""
    table = _table(run, "control")
    card = {column: value for column, value in _card(run).items() if column in CONTROL and column not in table}
    for column, value in {"experiment": run.experiment, "scale": run.scale, **card}.items():
        table[column] = value
    return table


def _first_loop(run: StoredRun) -> "pd.DataFrame":
    if run.experiment not in CLOSED_LOOPS_OF:
        return _nothing()
    loops = _table(run, "closed_loops")
    return loops if loops.empty else loops[loops["loop"] == loops["loop"].min()]


def _stages(runs: Sequence[StoredRun]) -> list[dict[str, Any]]:
    known: dict[str, Mapping[str, Any]] = {}
    return [row for run in _distinct(runs) for row in stages_of(run, known)]


def _run_row(run: StoredRun) -> dict[str, Any]:
    return {
        **_place(run),
        **_card(run),
        "outcome": run.outcome,
        "error": run.error,
        "stale": run.stale,
        "seeds": list(run.card.get("seeds") or []),
        "member_status": [str(status) for status in run.card.get("member_status") or []],
        "command": run.command,
    }


def _place(run: StoredRun) -> dict[str, str]:
    return {"run": run.id, "experiment": run.experiment, "scale": run.scale, "setting": _setting(run)}


def _card(run: StoredRun) -> dict[str, Any]:
    try:
        return {column: as_card_value(column, run.card.get(column)) for column in CARD}
    except (TypeError, ValueError) as error:
        message = f"{run.folder / 'run.json'} has a run card of the wrong type ({error}); delete the folder, run again"
        raise UserError(message) from error


def _setting(run: StoredRun) -> str:
    if not run.card:
        return ""
    chosen = {key: value for key, value in run.card.items() if key not in NOT_CHOSEN}
    content = json.dumps([chosen, run.other_than_seeds], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:10]


def _table(run: StoredRun, name: str) -> "pd.DataFrame":
    import pandas as pd

    path = run.folder / f"{name}.parquet"
    # A fit without steps, such as least squares, leaves its curves empty.
    if not path.is_file() or path.stat().st_size == 0:
        return pd.DataFrame()
    return _read(path).assign(run=run.id)


def _bench(folder: Path) -> "pd.DataFrame":
    command = str((read_json(folder / "run.json").get("provenance") or {}).get("command") or "")
    return _read(folder / "bench.parquet").assign(run=folder.name, command=command)


def _read(path: Path) -> "pd.DataFrame":
    import pandas as pd

    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        message = f"{path} cannot be read ({error}); delete its folder and run again"
        raise UserError(message) from error


def _thinned(curves: "pd.DataFrame") -> "pd.DataFrame":
    """Each quantity at steps of its own: they are not all looked at as often."""
    import pandas as pd

    if curves.empty:
        return curves
    return pd.concat([_at_some_steps(one) for _, one in curves.groupby("name", sort=False)])


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
    if len(free):
        return free[free["member"] == members[0]]
    return shown.groupby(["member", "name"], sort=False).head(TRAJECTORY_POINTS)


def _nothing() -> "pd.DataFrame":
    import pandas as pd

    return pd.DataFrame()


def _together(tables: Sequence["pd.DataFrame"]) -> "pd.DataFrame":
    import pandas as pd

    filled = [table for table in tables if not table.empty]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame()
