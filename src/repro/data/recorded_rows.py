"""The rows of a recording in SI units, before anything is derived from them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from repro.data.data_options import RecordingFile
from repro.data.tables.read import RecordedTable
from repro.data.tables.units import OTHERS, SECONDS, factors, seconds
from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.inputs import generalised_force
from repro.mechanics.system import System

BRACKETED = re.compile(r"[\[(]([^\])]+)[\])]$")


@dataclass(frozen=True)
class RecordedRows:
    """Rows (sample, ...) of one file, or of several."""

    q: np.ndarray
    tau: np.ndarray
    time: np.ndarray
    episode: np.ndarray  # (sample,) int, changing at every restart; label is what the file says about it
    label: np.ndarray
    row: np.ndarray  # (sample,) int, position in its file, from 0
    test: np.ndarray  # (sample,) bool, of files for testing alone
    qd: np.ndarray | None = None  # as qdd None where they are not recorded
    qdd: np.ndarray | None = None
    notes: tuple[str, ...] = ()  # what was recognised, for the user

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that is there, by name."""
        named = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "notes"}
        return {name: array for name, array in named.items() if array is not None}


def samples_of(
    table: RecordedTable,
    source: RecordingFile,
    coordinates: Sequence[Coordinate],
    system: System | None = None,
    *,
    test: bool = False,
) -> RecordedRows:
    """The rows of one file; UserError for columns and values that do not fit the options.

    system: where its inputs are fewer than its coordinates, as many columns of tau are taken for its inputs.
    """
    columns = {role: table.names(names) for role, names in source.columns.named.items()}
    forces = columns.get("tau", [])
    are_inputs = system is not None and not source.driven and len(forces) == len(system.inputs) < len(coordinates)
    acted_on = [] if are_inputs else _acted_on(forces, coordinates, source.driven)
    _check_columns(columns, len(coordinates))
    values = {
        role: table.numbers(names) * _factors(table, source, role, names)
        for role, names in columns.items()
        if role not in ("time", "episode")
    }
    time, notes = _time(table, source, columns.get("time"))
    labels = table.frame[columns["episode"][0]] if "episode" in columns else None
    complete = np.all([np.isfinite(each).all(axis=1) for each in values.values()] + [np.isfinite(time)], axis=0)
    if labels is not None:
        complete &= labels.notna().to_numpy()
    if not complete.all():
        if source.missing == "refuse":
            raise UserError(_incomplete(table, columns, values | {"time": time[:, None]}, complete))
        notes.append(f"{table.path.name}: {np.sum(~complete)} of {len(complete)} rows have no number and are left out")
    row = np.flatnonzero(complete)
    if not len(row):
        raise UserError(f"{table.path}: no row has a number in every column that is used")
    values, time = {role: each[row] for role, each in values.items()}, time[row]
    label = np.full(len(row), table.path.name.partition(".")[0])
    if labels is not None:
        label = labels.iloc[row].convert_dtypes().astype(str).to_numpy(dtype=str)  # 3 for 3.0
    restart = np.append(False, (label[1:] != label[:-1]) | (np.diff(row) > 1))
    _check_increasing(table, time, row, restart)
    tau = np.zeros_like(values["q"])
    if are_inputs and system is not None:
        tau = generalised_force(system, values["q"], values["tau"])
    elif acted_on:
        tau[:, acted_on] = values["tau"]
    found = values | {"tau": tau, "time": time, "episode": np.cumsum(restart), "label": label, "row": row}
    return RecordedRows(**found, test=np.full(len(row), test), notes=tuple(notes))


def joined(parts: Sequence[RecordedRows]) -> RecordedRows:
    """Several files one after the other; each starts an episode."""
    together = {name: np.concatenate([part.arrays()[name] for part in parts]) for name in parts[0].arrays()}
    starts = np.cumsum([0, *(part.episode[-1] + 1 for part in parts[:-1])])
    together["episode"] += np.repeat(starts, [len(part.q) for part in parts])
    return RecordedRows(**together, notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)))


def chosen(samples: RecordedRows, rows: np.ndarray) -> RecordedRows:
    """These rows, in this order (positions, or one bool per row)."""
    return RecordedRows(**{name: array[rows] for name, array in samples.arrays().items()}, notes=samples.notes)


def _acted_on(names: Sequence[str], coordinates: Sequence[Coordinate], driven: Sequence[str]) -> list[int]:
    """The positions of the coordinates that the columns of tau act on."""
    known = [coordinate.name for coordinate in coordinates]
    if unknown := [name for name in driven if name not in known]:
        raise UserError(f"data.driven = {unknown}: choose from the coordinates {', '.join(known)}")
    if len(names) in (0, len(driven)):
        return [known.index(name) for name in driven[: len(names)]]
    if len(names) == len(known):
        return [*range(len(known))]
    raise UserError(
        f"columns.tau names {len(names)} columns {list(names)}: give one for each of {', '.join(known)}, none, or "
        f"fewer beside the coordinates that they act on, as data.driven=[{','.join(known[: len(names)])}]"
    )


def _check_columns(columns: Mapping[str, Sequence[str]], n_q: int) -> None:
    for role, names in columns.items():
        wanted = n_q if role in ("q", "qd", "qdd") else len(names) if role == "tau" else 1
        if len(names) != wanted:
            raise UserError(f"columns.{role} names {len(names)} columns {list(names)}: {wanted} needed")
    used = [(role, name) for role, names in columns.items() for name in names]
    for _, name in used:
        others = [other for other, same in used if same == name]
        if len(others) > 1:
            raise UserError(f"column {name!r} is named twice, in {' and '.join(f'columns.{each}' for each in others)}")


def _factors(table: RecordedTable, source: RecordingFile, role: str, names: Sequence[str]) -> list[float]:
    """Factors to SI units; UserError where the file names a unit that the options do not."""
    given = getattr(source.units, role)
    for name in () if given else names:
        unit, known = _unit_in(table, name), SECONDS if role == "time" else OTHERS
        base = unit.partition("/s")[0]
        if known.get(base, 1.0) != 1.0:
            example = ",".join(_unit_in(table, each).partition("/s")[0] or "..." for each in names)
            raise UserError(f"{table.path}: column {name!r} is in {unit}: give data.units.{role}=[{example}]")
    return factors(given, len(names), role)


def _unit_in(table: RecordedTable, name: str) -> str:
    """The unit of a column as the file writes it: in a row below the names, or in brackets behind the name."""
    bracketed = BRACKETED.search(name)
    return table.units.get(name) or (bracketed[1].strip() if bracketed else "")


def _time(table: RecordedTable, source: RecordingFile, names: Sequence[str] | None) -> tuple[np.ndarray, list[str]]:
    if names:
        _factors(table, source, "time", names)
        return seconds(table, names[0], *(source.units.time or (None,)))
    if source.time_step is None:
        raise UserError(f"{table.path}: name a time column (columns.time) or give time_step in seconds")
    return np.arange(len(table.frame)) * source.time_step, []


def _incomplete(
    table: RecordedTable, columns: Mapping[str, Sequence[str]], values: Mapping[str, np.ndarray], complete: np.ndarray
) -> str:
    row = int(np.argmin(complete))
    bad = [name for role, names in columns.items() if role in values for name in names]
    gaps = [not np.isfinite(value) for role in columns if role in values for value in values[role][row]]
    name = next((name for name, gap in zip(bad, gaps, strict=True) if gap), columns.get("episode", [""])[0])
    count = int(np.sum(~complete))
    return (
        f"{table.path}: column {name!r} has no finite number in data row {row + 1} (so have {count} of {len(complete)} "
        "rows); correct it, or leave such rows out with data.missing=drop"
    )


def _check_increasing(table: RecordedTable, time: np.ndarray, row: np.ndarray, restart: np.ndarray) -> None:
    steps = np.diff(time)
    wrong = np.flatnonzero((steps <= 0) & ~restart[1:])
    if len(wrong):
        k = int(wrong[0])
        raise UserError(
            f"{table.path}: time must increase from row to row within an episode; data row {row[k + 1] + 1} has "
            f"{time[k + 1]:.9g} s after {time[k]:.9g} s (in {len(wrong)} rows): sort the rows, or name the column "
            "that counts the episodes (columns.episode)"
        )
