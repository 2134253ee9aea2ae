"""Stored results in a notebook: a tidy table of all runs, and one run with everything in its folder."""

import warnings
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.errors import UserError
from repro.tracking import index
from repro.tracking.experiment_list import experiment_lists
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.record import Record, opened

if TYPE_CHECKING:
    import pandas as pd

_METRICS = "metrics.parquet"
_COLUMNS = ["run", "experiment", "scale", "member", "split", "metric", "value", "unit"]
_MOST_VALUES = 8  # in a message
_MOST_LISTED = 5  # ids


def load_stage(id: str, *, root: Path | str | None = None) -> Record:
    """The stage that an id, its start or the digits at its end name; UserError for none, several or a damaged one."""
    return opened(resolve(Paths(Path(root or outputs_root())), id))


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
