"""Stored results in a notebook: a tidy table of all runs, and one run with everything in its folder."""

import warnings
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.errors import UserError
from repro.tracking import index, record
from repro.tracking.experiment_list import experiment_lists
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.record import Record

if TYPE_CHECKING:
    import pandas as pd

_METRICS = "metrics.parquet"
_COLUMNS = ["run", "experiment", "scale", "member", "split", "metric", "value", "unit"]
_MOST_VALUES = 8  # in a message
_MOST_LISTED = 5  # ids


@dataclass(frozen=True)
class Run:
    """One stored stage.

    record  run.json: id, outcome, identity, summary, provenance, failure
    """

    record: Record

    @property
    def id(self) -> str:
        """Its id."""
        return self.record.id

    @property
    def config(self) -> Mapping[str, Any]:
        """Resolved configuration of this stage alone."""
        return dict(self.record.identity.config)

    @property
    def upstream(self) -> "dict[str, Run]":
        """Role -> the stage its data, fit, ... came from."""
        paths, stages = Paths(self.record.folder.parent.parent), {}
        for role, id in self.record.identity.upstream.items():
            if not any(paths.folder(kind, id).is_dir() for kind in paths.kinds()):
                command = self.record.provenance.command
                raise UserError(f"{id}, the {role} of {self.id}, was deleted; this makes it again: {command}")
            stages[role] = Run(load_record(paths, id))
        return stages

    def table(self, name: str) -> "pd.DataFrame":
        """A Parquet file of its folder: "metrics", "curves", "trajectories", ... UserError for an unknown one."""
        import pandas as pd

        file = self.record.path(f"{name}.parquet")
        if not file.is_file():
            tables = ", ".join(sorted(path.stem for path in self.record.folder.glob("*.parquet"))) or "none"
            raise UserError(f"{self.id} has no table {name}; it has: {tables}")
        return pd.read_parquet(file)


def load_run(id: str, *, root: Path | str | None = None) -> Run:
    """The stage that an id, its start or the digits at its end name; raises UserError when none or several do."""
    return Run(load_record(Paths(Path(root or outputs_root())), id))


def load_record(paths: Paths, id: str) -> Record:
    """The record of the stage that an id names, see `load_run`; UserError when it is damaged too."""
    folder = resolve(paths, id)
    try:
        return record.read(folder)
    except record.Damage as damage:
        raise UserError(f"{folder} is damaged ({damage}): run the command that made it again") from damage


def digits(id: str) -> str:
    """The digits at the end of an id, which alone identify it."""
    return id.rpartition("-")[2]


def matching(ids: Iterable[str], text: str) -> list[str]:
    """The ids that a text names: the one that equals it, else those that start with it, or whose digits do."""
    candidates = list(ids)
    if text in candidates:
        return [text]
    return [id for id in candidates if id.startswith(text) or digits(id).startswith(text)]


def resolve(paths: Paths, text: str) -> Path:
    """The folder of the one stage that a text names, among the finished ones first, then among the failures.

    Raises UserError when none or several fit.
    """
    for shelf in ("", ".failed"):
        folders = {id: paths.root / kind / shelf / id for kind in paths.kinds() for id in paths.ids(kind, shelf)}
        fitting = matching(folders, text)
        if len(fitting) == 1:
            return folders[fitting[0]]
        if fitting:
            some = ", ".join(fitting[:_MOST_LISTED]) + (", ..." if len(fitting) > _MOST_LISTED else "")
            raise UserError(f"{text} fits {len(fitting)} stages: {some}; type more of the id")
    raise UserError(f"no stage {text} under {paths.root}; `repro runs` lists the ids")


def load_runs(*, root: Path | str | None = None, **filters: Any) -> "pd.DataFrame":
    """All finished runs as one tidy table.

    Parameters
    ----------
    root
        Folder of the results; $REPRO_OUTPUTS, or `outputs`, by default.
    filters
        A column, and a value, a collection of values or a function of the value:
        `load_runs(experiment="sip_basis", metric=["mae_tau", "mae_qdd"], n_train=lambda n: n > 1000)`.

    Returns
    -------
    pandas.DataFrame
        One row per (experiment, run, member, split, metric) with its value, its unit and the run's card. Runs that no
        experiment lists have an empty experiment and scale.

    Raises
    ------
    UserError
        For a column that does not exist.
    """
    import pandas as pd

    paths = Paths(Path(root or outputs_root()))
    runs = [entry for entry in index.load(paths).finished().values() if entry.kind == "runs"]
    cards = pd.DataFrame(
        {"run": run.id} | {key: value for key, value in run.card.items() if not isinstance(value, list | Mapping)}
        for run in runs
        if (paths.folder("runs", run.id) / _METRICS).is_file()
    )
    if cards.empty:
        return pd.DataFrame(columns=_COLUMNS)
    jobs = [(job.run, each.experiment, each.scale) for each in experiment_lists(paths) for job in each.jobs]
    listed = pd.DataFrame(jobs, columns=_COLUMNS[:3])
    cards = cards.merge(listed.drop_duplicates(), how="left", on="run").fillna({"experiment": "", "scale": ""})
    for key, condition in filters.items():
        if key in cards:
            cards = _filtered(cards, key, condition)
    tables = [pd.read_parquet(paths.folder("runs", run) / _METRICS).assign(run=run) for run in cards["run"].unique()]
    whole = cards.merge(pd.concat(tables) if tables else pd.DataFrame(columns=["run", *_COLUMNS[3:]]), on="run")
    whole = whole[[*_COLUMNS, *cards.columns.difference(_COLUMNS, sort=False)]]
    for key, condition in filters.items():
        if key not in whole:
            raise UserError(f"no column {key} to filter by; there are: {', '.join(whole.columns)}")
        if key not in cards:
            whole = _filtered(whole, key, condition)
    return whole.reset_index(drop=True)


def _filtered(table: "pd.DataFrame", key: str, condition: Any) -> "pd.DataFrame":
    """The rows whose value fits; a warning where none does."""
    present = table[key].unique()
    fitting = [value for value in present if _fits(value, condition)]
    if len(present) and not fitting and not callable(condition):
        values = sorted(map(str, present))
        some = f"{', '.join(values[:_MOST_VALUES])}{', ...' * (len(values) > _MOST_VALUES)}"
        warnings.warn(f"no run has {key}={condition!r}; there are {some}", stacklevel=3)
    return table[table[key].isin(fitting)]


def _fits(value: Any, condition: Any) -> bool:
    if callable(condition):
        return bool(condition(value))
    if isinstance(condition, Collection) and not isinstance(condition, str):
        return value in condition
    return bool(value == condition)
