"""One's own recordings, from files of text or Parquet."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from repro.data.data_options import RecordingFile
from repro.data.dataset import Dataset, Measurement, training_size
from repro.data.differentiation import difference, differences_of_positions
from repro.data.plausibility import contradictions, remarks
from repro.data.recorded_rows import RecordedRows, chosen, joined, samples_of
from repro.data.sensors import estimated, unwrapped
from repro.data.tables.read import files_of, read_table
from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import System

UNEVEN = 0.01  # relative deviation of a sampling interval from the median that is worth a warning
GAP = 10.0  # a sampling interval of so many medians ends an episode

ESTIMATED = ("savitzky_golay", "smoothed")  # labels for which q, qd and qdd are all estimates

Stamp = tuple[str, int, int]  # name of a file, time of its last change, size


def from_file(source: RecordingFile, system: System | None, *, members: int = 1) -> Dataset:
    """Read a recording, one row per sample; all members have the same data.

    system: the one whose coordinates are recorded, where the source names none. What is derived, converted or
    suspicious is said in provenance["warnings"]. UserError for what is wrong with the files, and, unless source.checks
    is "warn", for columns that contradict each other.
    """
    coordinates = source.coordinates.described()
    if coordinates:
        system = None
    elif system is None:
        raise UserError("data.coordinates.names: name the coordinates, or choose a system that has them")
    else:
        coordinates = system.coordinates
    stats = [[(path, path.stat()) for path in files] for files in files_read(source)]
    stamps = (tuple((str(path), stat.st_mtime_ns, stat.st_size) for path, stat in files) for files in stats)
    return _read(source, system, coordinates, *stamps).of_members([0] * members)


def files_read(source: RecordingFile) -> tuple[list[Path], list[Path]]:
    """The files to learn from, and those for testing alone; UserError where there are none."""
    files, tests = ([file for path in paths for file in files_of(path)] for paths in (source.paths, source.test_paths))
    return files, tests


@lru_cache(maxsize=8)
def _read(
    source: RecordingFile,
    system: System | None,
    coordinates: tuple[Coordinate, ...],
    files: tuple[Stamp, ...],
    tests: tuple[Stamp, ...],
) -> Dataset:
    """The recording of one member; a file is read once, where the settings are checked and where data are made."""
    parts = [
        samples_of(read_table(Path(stamp[0])), source, coordinates, system, test=number >= len(files))
        for number, stamp in enumerate((*files, *tests))
    ]
    samples, notes = _episodes(joined(parts), source.labels)
    samples, turned = _without_wraps(samples, coordinates)
    names = ", ".join(Path(stamp[0]).name for stamp in (*files, *tests)[:3]) + (", ..." if len(parts) > 3 else "")
    problems = [*contradictions(samples, coordinates)]
    if problems and source.checks == "refuse":
        raise UserError(f"{names}: {problems[0]} (data.checks=warn reads it as it is)")
    suspicious = [*remarks(samples, coordinates)]
    samples, n_train = _parted(samples, source)
    (q, qd, qdd), recording, derived = _motion(samples, source.labels)
    if not samples.tau.any():
        derived.append("no force acts in this recording: the scale of L cannot be learned from it")
    steps = np.diff(samples.time)[samples.episode[1:] == samples.episode[:-1]]
    if not len(steps):
        raise UserError(f"{names}: every episode has a single sample")
    time_step = float(np.median(steps)) if source.time_step is None else source.time_step
    if abs(np.median(steps) - time_step) > UNEVEN * time_step:
        differs = f"time_step = {time_step} s, but the time column advances by {np.median(steps):.6g} s"
        raise UserError(f"{names}: {differs}")
    uneven = float(np.abs(steps / time_step - 1).max())
    if uneven > UNEVEN:
        derived.append(f"the sampling intervals differ by up to {uneven:.0%} from their median")
    warnings = [*samples.notes, *notes, *turned, *problems, *suspicious, *derived]
    return Dataset(
        q=q[None],
        qd=qd[None],
        qdd=qdd[None],
        tau=samples.tau[None],
        time=_running_on(samples.time, samples.episode, time_step),
        episode=np.cumsum(np.append(0, np.diff(samples.episode) != 0)),
        n_train=n_train,
        coordinates=coordinates,
        time_step=time_step,
        measurement=recording,
        provenance={"source": "file", "file": names, "columns": source.columns.plain(), "warnings": warnings},
    )


def _episodes(samples: RecordedRows, labels: str) -> tuple[RecordedRows, list[str]]:
    """A gap in time ends an episode, and what is too short for the differences that it needs is left out."""
    notes = []
    steps, same = np.diff(samples.time), np.diff(samples.episode) == 0
    usual = float(np.median(steps[same])) if same.any() else 0.0
    gaps = same & (steps > GAP * usual)
    if gaps.any():
        first = int(np.argmax(gaps))
        notes.append(
            f"{gaps.sum()} gaps of up to {steps[gaps].max():.3g} s, the first after data row {samples.row[first] + 1}: "
            "each ends an episode"
        )
    episode = np.cumsum(np.append(0, gaps | ~same))
    needed = 3 if samples.qd is None or labels in ESTIMATED else 2 if samples.qdd is None else 1
    long_enough = np.bincount(episode)[episode] >= needed
    if not long_enough.all():
        notes.append(f"{np.sum(~long_enough)} rows are left out: their episodes have fewer than {needed} samples")
    if not long_enough.any():
        raise UserError(f"no episode has the {needed} samples that differences need")
    return chosen(replace(samples, episode=episode), long_enough), notes


def _without_wraps(samples: RecordedRows, coordinates: Sequence[Coordinate]) -> tuple[RecordedRows, list[str]]:
    """Angles recorded modulo a turn, made continuous within each episode."""
    q, notes = samples.q, []
    inside = np.diff(samples.episode) == 0
    for k, coordinate in enumerate(coordinates):
        jumps = int(np.sum(inside & (np.abs(np.diff(q[:, k])) > np.pi)))
        if not coordinate.is_angle or not jumps or np.ptp(q[:, k]) > 2 * np.pi + 1e-6:
            continue
        q = unwrapped(q, [k], samples.episode)
        notes.append(f"{coordinate.name} is recorded modulo a turn: {jumps} jumps were taken out")
    return replace(samples, q=q), notes


def _parted(samples: RecordedRows, source: RecordingFile) -> tuple[RecordedRows, int]:
    """Training rows first, and how many they are."""
    if not samples.test.any() and not source.test_episodes:
        return samples, training_size(len(samples.q), source.train_fraction, "rows")
    wanted = [str(each) for each in source.test_episodes]
    if unknown := [each for each in wanted if each not in samples.label]:
        there = ", ".join(list(dict.fromkeys(samples.label.tolist()))[:20])
        raise UserError(f"data.test_episodes = {unknown}: there are the episodes {there}")
    test = samples.test | np.isin(samples.label, wanted)
    if test.all():
        raise UserError("data.test_episodes, data.test_path: nothing is left to learn from")
    return chosen(samples, np.argsort(test, kind="stable")), int(np.sum(~test))


Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # q, qd, qdd, (sample, n_q) each


def _motion(rows: RecordedRows, labels: str) -> tuple[Motion, Measurement, list[str]]:
    """The motion as the method of `labels` makes it, what was recorded, and what is said about it."""
    recorded = Measurement(rows.q[None], None if rows.qd is None else rows.qd[None])
    if labels in ESTIMATED:
        q, qd, qdd, recorded = estimated(recorded, rows.time, rows.episode, labels)
        return (q[0], qd[0], qdd[0]), recorded, []
    if rows.qd is None:
        qd, qdd = differences_of_positions(rows.q, rows.time, rows.episode)
        what = "qd and qdd are not recorded: they were" if rows.qdd is None else "qd is not recorded: it was"
        kept = qdd if rows.qdd is None or labels == "differenced" else rows.qdd
        said = f"{what} differenced from q, which multiplies its noise; data.labels=smoothed estimates them"
        return (rows.q, qd, kept), recorded, [said]
    if rows.qdd is not None and labels == "recorded":
        return (rows.q, rows.qd, rows.qdd), recorded, []
    what = "qdd is not recorded: it was" if rows.qdd is None else "qdd was"
    said = f"{what} differenced from qd, which blurs it over each step and multiplies noise"
    return (rows.q, rows.qd, difference(rows.qd, rows.time, rows.episode)), recorded, [said]


def _running_on(time: np.ndarray, episode: np.ndarray, time_step: float) -> np.ndarray:
    """Time that increases from episode to episode, as simulated data have it."""
    running = time.copy()
    for start in np.flatnonzero(np.diff(episode)) + 1:
        if running[start] <= running[start - 1]:
            running[start:] += running[start - 1] + time_step - running[start]
    return running
