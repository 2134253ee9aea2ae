"""One's own recordings, from CSV or Parquet."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from repro.data.checks import check_positive, training_size
from repro.data.dataset import Dataset
from repro.data.differentiation import difference
from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate

if TYPE_CHECKING:
    import pandas as pd

ROLES = ("time", "q", "qd", "qdd", "tau", "episode")
UNEVEN = 0.01  # relative deviation of a sampling interval from the median that is worth a warning


def from_file(
    path: Path | str,
    *,
    columns: Mapping[str, Sequence[str]],
    coordinates: Sequence[Coordinate],
    time_step: float | None = None,
    train_fraction: float = 0.8,
    members: int = 1,
) -> Dataset:
    """Read a recording, one row a sample in SI units; the first train_fraction of the rows are for training.

    columns: names of the columns that hold each role, one a coordinate for q, qd, tau and (optional) qdd; one for time
    and (optional) episode. Without time, time_step in s is needed. Without qdd, qd is differenced within episodes and
    provenance["warnings"] says so. All members have the same data. UserError says what is wrong with the file.
    """
    path = Path(path)
    check_positive(members=members)
    _check_columns(columns, len(coordinates))
    table = _read(path)
    numbers = {role: _numbers(path, table, names) for role, names in columns.items() if names}
    samples = len(table)
    n_train = training_size(samples, train_fraction, "rows")
    episode = _episodes(numbers["episode"][:, 0]) if "episode" in numbers else np.zeros(samples, dtype=np.int64)
    time, time_step, warnings = _clock(path, numbers.get("time"), episode, time_step)
    if "qdd" not in numbers:
        numbers["qdd"] = difference(numbers["qd"], time, episode)
        warnings.append("qdd is not recorded: it was differenced from qd, which blurs it over each step")
    q, qd, qdd, tau = (np.repeat(numbers[role][None], members, axis=0) for role in ("q", "qd", "qdd", "tau"))
    return Dataset(
        q=q,
        qd=qd,
        qdd=qdd,
        tau=tau,
        time=time,
        episode=episode,
        n_train=n_train,
        coordinates=tuple(coordinates),
        time_step=time_step,
        provenance={
            "source": "file",
            "file": path.name,
            "columns": {role: list(names) for role, names in columns.items()},
            "warnings": warnings,
        },
    )


def _check_columns(columns: Mapping[str, Sequence[str]], n_q: int) -> None:
    if unknown := set(columns) - set(ROLES):
        raise UserError(f"columns: unknown role {sorted(unknown)[0]!r}: choose from {', '.join(ROLES)}")
    for role in ROLES:
        names = columns.get(role) or ()
        wanted = 1 if role in {"time", "episode"} else n_q
        if len(names) != wanted and (names or role in {"q", "qd", "tau"}):
            raise UserError(f"columns.{role} names {len(names)} columns {list(names)}: {wanted} needed")


def _read(path: Path) -> "pd.DataFrame":
    import pandas as pd

    readers: dict[str, Callable[[Path], pd.DataFrame]] = {".csv": pd.read_csv, ".parquet": pd.read_parquet}
    if path.suffix.lower() not in readers:
        raise UserError(f"{path}: the name must end in {' or '.join(readers)}")
    if not path.is_file():
        raise UserError(f"{path}: there is no such file")
    try:
        table = readers[path.suffix.lower()](path)
    except (OSError, ValueError) as error:  # the parsers' own errors are ValueErrors
        raise UserError(f"{path}: cannot be read as {path.suffix[1:]} ({error})") from error
    if table.empty:
        raise UserError(f"{path}: the file has no rows")
    return table


def _numbers(path: Path, table: "pd.DataFrame", names: Sequence[str]) -> np.ndarray:
    """Return (sample, column) finite numbers."""
    for name in names:
        if name not in table.columns:
            raise UserError(f"{path}: there is no column {name!r}; it has {', '.join(map(str, table.columns))}")
    try:
        values = table[list(names)].to_numpy(dtype=float)
    except (TypeError, ValueError) as error:
        raise UserError(f"{path}: columns {', '.join(names)} are not all numbers ({error})") from error
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        raise UserError(f"{path}: column {names[bad[0, 1]]!r} has no finite number in data row {bad[0, 0] + 1}")
    return values


def _episodes(labels: np.ndarray) -> np.ndarray:
    """Return 0, 0, ..., 1, 1, ...: a new episode wherever the label changes."""
    return np.append(0, np.cumsum(np.diff(labels) != 0))


def _clock(
    path: Path, recorded: np.ndarray | None, episode: np.ndarray, time_step: float | None
) -> tuple[np.ndarray, float, list[str]]:
    """Return time (sample,), the time step, and what is worth a warning."""
    if time_step is not None:
        check_positive(time_step=time_step)
    if recorded is None:
        if time_step is None:
            raise UserError(f"{path}: name a time column (columns.time) or give time_step in seconds")
        return np.arange(len(episode)) * time_step, time_step, []
    time = recorded[:, 0]
    steps = np.diff(time)[episode[1:] == episode[:-1]]
    if not len(steps) or steps.min() <= 0:
        raise UserError(f"{path}: time must increase from row to row within an episode")
    median = float(np.median(steps))
    if time_step is not None and abs(median - time_step) > UNEVEN * time_step:
        raise UserError(f"{path}: time_step = {time_step} s, but the time column advances by {median:.6g} s")
    uneven = float(np.abs(steps / median - 1).max())
    warnings = [f"the sampling intervals differ by up to {uneven:.0%} from their median"] if uneven > UNEVEN else []
    return time, median if time_step is None else time_step, warnings
