"""What the runs cost, and on which machine: from the provenance of their stages, a shared stage counted once."""

from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.results import Results
from repro.results.selectors import NotRunError
from repro.tracking.lazy_pandas import pd

HOUR = 3600.0
COLUMNS = {"processors": "processor", "cores": "cores", "systems": "system", "pythons": "python"}
FACTS = ("cpu_hours", "peak_gib", *COLUMNS)


def cost_fact(results: Results, name: str) -> str:
    """Write one of `FACTS`. Raises NotRunError where no stage was stored, ValueError for another name."""
    if name not in FACTS:
        raise ValueError(f"{name!r} is no fact of cost; allowed: {', '.join(FACTS)}")
    stages = _once(results)
    if stages.empty:
        raise NotRunError("the results do not say what their stages cost")
    if name == "cpu_hours":
        return writing.number(stages["cpu_s"].sum() / HOUR)
    if name == "peak_gib":
        return writing.number(stages["peak_memory_mib"].max() / 1024)
    values = {str(value) for value in stages[COLUMNS[name]].dropna()} - {""}
    return ", ".join(sorted(values))


def cost_table(results: Results) -> Table:
    """Make the table of processor time and memory by experiment; what several share stands with the first."""
    stages, rows = _once(results), []
    for experiment, group in stages.groupby("experiment", sort=True):
        runs = results.runs[results.runs["experiment"] == experiment]["run"].nunique()
        cpu, wall, peak = group["cpu_s"].sum() / HOUR, group["wall_s"].sum() / HOUR, group["peak_memory_mib"].max()
        data = {"experiment": experiment, "runs": runs, "cpu_hours": cpu, "wall_hours": wall, "peak_memory_mib": peak}
        rows.append(Row.of([], data))
    columns = ("experiment", "runs", "processor time [h]", "elapsed [h]", "peak memory [MiB]")
    caption = "Sums over the stages of all runs; a stage that several experiments share stands with the first of them."
    return Table("cost", "Cost", caption, columns, tuple(rows))


def _once(results: Results) -> "pd.DataFrame":
    """Every stage once, with the first experiment that lists its run."""
    first = results.runs.drop_duplicates("run").set_index("run")["experiment"]
    stages = results.stages.drop_duplicates("id")
    return stages.assign(experiment=stages["run"].map(first))
