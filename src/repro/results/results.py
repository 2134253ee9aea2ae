"""The gathered tables: everything that verdicts, tables and figures are made from."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from pathlib import Path

from repro.errors import UserError
from repro.results.run_setting import Measured, Metrics, RunSetting
from repro.results.table_schema import CARD, PANDAS_TYPES, TABLES, Row, records
from repro.tracking.files import replacing
from repro.tracking.lazy_pandas import pd
from repro.tracking.plain_data import Json

SENSITIVITY = "sensitivity"  # where its runs are listed, in the place of a scale


@dataclass(frozen=True)
class Results:
    """The result tables; columns and types as in `table_schema`. The sensitivity runs have tables of their own."""

    metrics: "pd.DataFrame"
    runs: "pd.DataFrame"
    curves: "pd.DataFrame"
    trajectories: "pd.DataFrame"
    bench: "pd.DataFrame"
    identifiability: "pd.DataFrame"
    control: "pd.DataFrame"
    closed_loops: "pd.DataFrame"
    stages: "pd.DataFrame"
    cases: "pd.DataFrame"
    sensitivity: "Results | None" = None

    @property
    def scale(self) -> str:
        """The scale these results come from; empty where nothing was run."""
        return min(self.runs["scale"], default="")

    @cached_property
    def rows(self) -> Sequence[Row]:
        """The rows of the runs table."""
        return records(self.runs)

    @cached_property
    def measured(self) -> Mapping[str, Metrics]:
        """The metrics of each run, in their stored order."""
        found: dict[str, dict[tuple[str, str], Measured]] = {}
        columns = ("run", "metric", "split", "unit", "member", "value")
        for run, name, split, unit, seed, value in zip(*(self.metrics[c].tolist() for c in columns), strict=True):
            found.setdefault(run, {}).setdefault((name, split), Measured(unit, {})).values[seed] = value
        return {**found}

    def with_runs(self, runs: "pd.DataFrame", control: "pd.DataFrame") -> "Results":
        """The same with other rows of runs and of closed loops; what was measured is taken apart once for all."""
        made = replace(self, runs=runs, control=control)
        vars(made)["measured"] = self.measured
        return made

    @cached_property
    def settings(self) -> tuple[RunSetting, ...]:
        """Every setting of every experiment that has finished runs, in the order of the runs."""
        grouped: dict[tuple[str, str], list[Row]] = {}
        for row in self.rows:
            if row["setting"] and row["outcome"] == "ok":
                grouped.setdefault((row["setting"], row["experiment"]), []).append(row)
        return tuple(
            RunSetting(
                {column: rows[0][column] for column in CARD},
                tuple(rows),
                {row["run"]: self.measured.get(row["run"], {}) for row in rows},
            )
            for rows in grouped.values()
        )

    @cached_property
    def unfinished(self) -> tuple[RunSetting, ...]:
        """The runs that failed or are missing, each as a setting without members."""
        return tuple(RunSetting(row, (row,)) for row in self.rows if row["setting"] and row["outcome"] != "ok")

    @cached_property
    def loops(self) -> Mapping[str, "pd.DataFrame"]:
        """The closed loops of each experiment."""
        return {str(name): group for name, group in self.control.groupby("experiment", sort=False)}

    @cached_property
    def configs(self) -> Mapping[str, Json]:
        """The settings of each run by dotted key."""
        return {run: json.loads(text or "{}") for run, text in zip(self.runs["run"], self.runs["config"], strict=True)}

    def __getstate__(self) -> dict[str, object]:
        # What is derived from the tables need not travel with them.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def save(self, folder: Path) -> None:
        """Write the tables as Parquet, each atomically."""
        for name in TABLES:
            with replacing(folder / f"{name}.parquet") as temporary:
                getattr(self, name).to_parquet(temporary, compression="zstd", index=False)
        if self.sensitivity is not None:
            self.sensitivity.save(folder / SENSITIVITY)

    @classmethod
    def load(cls, folder: Path) -> "Results":
        """Read the tables back; one that is not there is empty. Raises UserError for a damaged or foreign folder."""
        if not (folder / "metrics.parquet").is_file():
            raise UserError(f"{folder} holds no metrics.parquet; name a folder of results, such as paper/results")
        paths = {name: folder / f"{name}.parquet" for name in TABLES}
        tables = {name: typed(name, read_table(path) if path.is_file() else ()) for name, path in paths.items()}
        inner = folder / SENSITIVITY
        return cls(**tables, sensitivity=cls.load(inner) if inner.is_dir() else None)


def read_table(path: Path, remedy: str = "make it again with `repro report`") -> "pd.DataFrame":
    """Read a Parquet file. Raises UserError naming a damaged one, with the remedy."""
    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise UserError(f"{path} cannot be read ({error}); {remedy}") from error


def typed(name: str, rows: "pd.DataFrame | Iterable[Mapping[str, object]]") -> "pd.DataFrame":
    """Bring rows to the fixed columns and types of one result table; a missing column is empty."""
    frame = rows if isinstance(rows, pd.DataFrame) else pd.DataFrame(list(rows))
    return _typed(name, frame) if len(frame) else _without_rows(name).copy()


@cache
def _without_rows(name: str) -> "pd.DataFrame":
    return _typed(name, pd.DataFrame())


def _typed(name: str, frame: "pd.DataFrame") -> "pd.DataFrame":
    schema = TABLES[name]
    # Most columns of most tables are missing: one empty column per type serves them all.
    nothing = pd.Series(float("nan"), index=frame.index)
    empty = {kind: _of_kind(nothing, kind) for kind in {schema[column] for column in schema if column not in frame}}
    columns = {c: _of_kind(frame[c], kind) if c in frame else empty[kind] for c, kind in schema.items()}
    return pd.DataFrame(columns, index=frame.index)


def _of_kind(values: "pd.Series", kind: type) -> "pd.Series":
    """A column of one type of the schema, missing values filled."""
    if kind is str:
        values = values.fillna("") if values.dtype == "str" else values.astype("object").where(values.notna(), "")
    elif kind is list:
        values = values.map(lambda entry: [] if entry is None or isinstance(entry, float) else list(entry))
    return values.astype(PANDAS_TYPES[kind])  # type: ignore[call-overload, no-any-return]
