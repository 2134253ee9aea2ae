"""Closed loops by setting and conditions: how many succeed, how near they come to the obstacle, what a step costs."""

from typing import Any, Literal

from pydantic.dataclasses import dataclass as checked

from repro.report.tables.table import Row, Table
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.statistics import share
from repro.results.table_schema import cell_text, plain
from repro.tracking.lazy_pandas import pd

ALWAYS = ("system", "model", "setting")
# Named where they differ within an experiment.
IF_VARIED = (
    *("basis", "hidden", "objective", "optimiser", "energies", "task", "intervals", "horizon_s", "adaptive"),
    *("seconds", "mismatch", "mismatch_kind", "noise", "disturbance", "delay", "friction"),
)
KEY_TITLES = {"task": "start", "horizon_s": "horizon [s]", "seconds": "length [s]", "mismatch_kind": "of"}
MEASURED = (
    *("loops", "success", "contacts", "clearance [m]", "erect from [s]", "offset [m]", "median [ms]", "p95 [ms]"),
    *("p99 [ms]", "iterations", "second try", "old plan", "no force", "killed"),
)
MEDIANS = ("held_from_s", "steady_error_m", "solve_ms_median", "solve_ms_p95", "solve_ms_p99", "iterations_median")
MEANS = ("fallbacks_1", "fallbacks_2", "fallbacks_3")
CAPTION = (
    "Success: within the tolerance of the task's goal for all of the last 2 s (pendulums on a cart: every angle within "
    "5 degrees of upright and |x - x_des| < 0.05 m), and never in contact with an obstacle; share with its 95 % Wilson "
    "interval. Least clearance over all loops; time from which erect, offset and CPU time per step (median, 95th and "
    "99th percentile of a loop's steps) as medians over loops; steps per loop that took a second try, followed an old "
    "plan, or had no force; solver calls that ran out of CPU time."
)


@checked(frozen=True)
class LoopTable:
    """A table of the closed loops of one experiment."""

    kind: Literal["loops"]
    name: str
    experiment: str
    title: str

    def make(self, results: Results) -> Table:
        """Make one row per setting and conditions; without loops it has no rows."""
        loops = results.control[results.control["experiment"] == self.experiment]
        varied = [column for column in IF_VARIED if loops[column].map(cell_text).nunique() > 1]
        keys = [*ALWAYS, *varied]
        titles = (*(KEY_TITLES.get(key, key) for key in keys), *MEASURED)
        grouped = loops.groupby([loops[key].map(cell_text) for key in keys], sort=False)
        rows = tuple(_row(results, keys, group) for _, group in grouped)
        return Table(self.name, self.title, CAPTION, titles, rows)


def _row(results: Results, keys: list[str], loops: "pd.DataFrame") -> Row:
    over_loops = {**loops[[*MEDIANS]].median(), **loops[[*MEANS]].mean()}
    place = {key: cell_text(loops[key].iloc[0]) for key in keys}
    runs = {*loops["run"]}
    values: dict[str, Any] = {
        **place,
        "loops": len(loops),
        "success": share(loops["success"].to_numpy(dtype=bool)),
        "contacts": int(loops["contact"].sum()),
        "clearance_min_m": float(loops["clearance_min_m"].min()),
        **{name: plain(value) for name, value in over_loops.items()},
        "killed": int(loops["killed"].sum()),
    }
    texts = {key: written(key, value) for key, value in place.items()}
    made_from = [row for row in results.rows if row["run"] in runs]
    return Row.of(made_from, values, texts, anchor=place["model"] == "truth")
