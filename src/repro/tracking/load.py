"""Stored results in a notebook: a tidy table of all runs, and one run with everything in its folder."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.errors import UserError
from repro.tracking import index, record
from repro.tracking.listed_jobs import listed_jobs
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.record import Record

if TYPE_CHECKING:
    import pandas as pd

_METRICS = "metrics.parquet"
_FIRST = ["run", "experiment", "scale"]
_COLUMNS = [*_FIRST, "member", "split", "metric", "value", "unit"]
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
    def upstream(self) -> dict[str, Run]:
        """Role -> the stage its data, fit, ... came from."""
        upstream = self.record.identity.upstream
        return {role: Run(load_record(self._paths, id)) for role, id in upstream.items() if self._stored(role, id)}

    @property
    def _paths(self) -> Paths:
        return Paths(self.record.folder.parent.parent)

    def _stored(self, role: str, id: str) -> bool:
        if any(self._paths.folder(kind, id).is_dir() for kind in self._paths.kinds()):
            return True
        command = self.record.provenance.command
        raise UserError(f"{id}, the {role} of {self.id}, was deleted; this makes it again: {command}")

    def table(self, name: str) -> pd.DataFrame:
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


def load_runs(*, root: Path | str | None = None, **filters: Any) -> pd.DataFrame:
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
    listed: dict[str, dict[tuple[str, str], None]] = {}  # run -> the (experiment, scale) pairs that list it
    for job in listed_jobs(paths):
        listed.setdefault(job.run, {})[job.experiment, job.scale] = None
    carded = []
    for entry in index.load(paths).finished().values():
        if entry.kind == "runs" and (paths.folder(entry.kind, entry.id) / _METRICS).is_file():
            card = {key: value for key, value in entry.card.items() if not isinstance(value, list | Mapping)}
            for experiment, scale in listed.get(entry.id, {("", ""): None}):
                carded.append({"run": entry.id, "experiment": experiment, "scale": scale, **card})
    if not carded:
        return pd.DataFrame(columns=_COLUMNS)
    known = {key for columns in carded for key in columns}
    for key, condition in filters.items():
        if key in known:
            carded = _filtered(carded, key, condition)
    parts = [pd.read_parquet(paths.folder("runs", columns["run"]) / _METRICS).assign(**columns) for columns in carded]
    whole = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=_COLUMNS)
    whole = whole[_FIRST + [name for name in whole.columns if name not in _FIRST]]
    for key, condition in filters.items():
        if key not in whole and key not in known:
            raise UserError(f"no column {key} to filter by; there are: {', '.join([*whole.columns, *known])}")
        if key not in known and not whole.empty:
            fitting = {value for value in whole[key].unique() if _fits(value, condition)}
            whole = whole[whole[key].isin(fitting)]
            if not fitting:
                _warn(key, condition, [])
    return whole.reset_index(drop=True)


def _filtered(cards: list[dict[str, Any]], key: str, condition: Any) -> list[dict[str, Any]]:
    left = [card for card in cards if _fits(card.get(key), condition)]
    if cards and not left:
        _warn(key, condition, [card.get(key) for card in cards])
    return left


def _warn(key: str, condition: Any, present: Iterable[Any]) -> None:
    if not callable(condition):
        values = sorted({str(value) for value in present})
        some = f"{', '.join(values[:_MOST_VALUES])}{', ...' * (len(values) > _MOST_VALUES)}"
        warnings.warn(f"no run has {key}={condition!r}{f'; there are {some}' if some else ''}", stacklevel=4)


def _fits(value: Any, condition: Any) -> bool:
    if callable(condition):
        return bool(condition(value))
    if isinstance(condition, Collection) and not isinstance(condition, str):
        return value in condition
    return bool(value == condition)
