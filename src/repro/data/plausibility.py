"""Whether the columns of a recording agree with each other: positions with velocities, units, stuck and damaged values.

The test of positions against velocities: over stretches of a few samples inside an episode, the change of q is compared
with the integral of qd by the trapezoidal rule.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from repro.data.recorded_rows import RecordedRows
from repro.mechanics.coordinate import Coordinate

STRETCHES = (3, 10, 30, 100)  # samples; noise and quantisation need longer ones than fast motion
FEWEST = 8  # stretches of a length that say something
LOCAL = 10  # samples, among which a stuck or missing one is seen
AGREES, CONTRADICTS = 0.05, 0.5  # share of the squared change of q that qd leaves unexplained
KNOWN = {  # change of q divided by the integral of qd -> what explains it
    180 / math.pi: "is the position in degrees and the velocity in rad/s? use data.units.q",
    math.pi / 180: "is the position in rad and the velocity in deg/s? use data.units.qd",
    1e-3: "is the time in ms? use data.units.time=[ms]",
    1e-6: "is the time in us? use data.units.time=[us]",
    1e-9: "is the time in ns? use data.units.time=[ns]",
    1e3: "is the position in mm and the velocity in m/s? use data.units.q",
    2 * math.pi: "is the velocity in turns per second? use data.units.qd",
    60 / (2 * math.pi): "is the position in other units than the velocity? use data.units",
    2 * math.pi / 60: "is the velocity in rpm? use data.units.qd",
}
LARGE_ANGLE = 25.0  # rad, four turns: more often degrees than rotation
PEAK = 1e3  # times what 99 of 100 values stay below
FAST, SLOW = 1e-5, 1.0  # s, usual sampling intervals


@dataclass(frozen=True)
class Agreement:
    """How the change of a coordinate compares with the integral of its velocity.

    ratio        of the one to the other, by least squares
    unexplained  share of the squared change that the velocity leaves over
    scaled       the same after the ratio is taken out
    first_wrong  the sample where the first short stretch begins that is wrong by the usual change or more, or None
    """

    ratio: float
    unexplained: float
    scaled: float
    first_wrong: int | None = None


@np.errstate(over="ignore", invalid="ignore")  # a damaged row may hold 1e200
def agreement(value: np.ndarray, rate: np.ndarray, time: np.ndarray, episode: np.ndarray) -> Agreement | None:
    """The best agreement over all lengths of stretches (arrays (sample,)); None where nothing moves."""
    inside = episode[1:] == episode[:-1]
    steps = np.where(inside, np.diff(time) * (rate[1:] + rate[:-1]) / 2, 0.0)
    integral = np.append(0.0, np.cumsum(steps))
    found, first_wrong = list[Agreement](), None
    for length in STRETCHES:
        starts = np.arange(0, len(value) - length, length)
        starts = starts[episode[starts] == episode[starts + length]]
        if len(starts) < FEWEST:
            continue
        change, expected = (each[starts + length] - each[starts] for each in (value, integral))
        total, squared = float(change @ change), float(expected @ expected)
        if total == 0 and squared == 0:
            continue
        ratio = float(change @ expected) / squared if squared else math.inf
        wrong = np.abs(change - expected) > math.sqrt(total / len(change))
        unexplained = float(np.sum((change - expected) ** 2)) / total if total else math.inf
        scaled = 1 - (ratio * float(change @ expected) / total if total and squared else 0.0)
        if length == LOCAL and wrong.any() and unexplained < CONTRADICTS:
            first_wrong = int(starts[np.argmax(wrong)])
        found.append(Agreement(ratio, unexplained, scaled))
    if not found:
        return None
    return replace(min(found, key=lambda each: min(each.unexplained, each.scaled)), first_wrong=first_wrong)


def contradictions(rows: RecordedRows, coordinates: Sequence[Coordinate]) -> Iterator[str]:
    """Lines for what cannot be right."""
    orders = [each for each in (rows.q, rows.qd, rows.qdd) if each is not None]
    names = [f"{coordinate.name}{ending}" for ending in ("", "d", "dd") for coordinate in coordinates]
    columns = dict(zip(names, np.concatenate(orders, axis=1).T, strict=False))
    for name, column in columns.items():
        size = np.abs(column - np.median(column))
        usual = float(np.quantile(size, 0.99))
        if usual > 0 and size.max() > PEAK * usual:
            k = int(size.argmax())
            yield (
                f"{name} is {column[k]:.3g} in data row {rows.row[k] + 1}, where 99 of 100 values lie within "
                f"{usual:.3g} of their median: correct or remove the row"
            )
            return
    for (name, column), (other, same) in combinations(columns.items(), 2):
        if np.ptp(column) > 0 and np.array_equal(column, same):
            yield f"{name} and {other} have the same values: two columns are swapped or repeated"
            return
    for order, (value, rate) in enumerate(pairwise(orders)):
        for k, coordinate in enumerate(coordinates):
            name = f"the velocity of {coordinate.name}" if order else coordinate.name
            of_it = f"the {'acceleration' if order else 'velocity'} of {coordinate.name}"
            found = agreement(value[:, k], rate[:, k], rows.time, rows.episode)
            if found is None or found.unexplained <= CONTRADICTS:
                continue
            if found.scaled <= AGREES:
                known = [text for ratio, text in KNOWN.items() if abs(math.log(abs(found.ratio) / ratio)) < 0.03]
                what = known[0] if known else "a sign or a unit differs"
                yield f"{name} changes {found.ratio:.3g} times as much as {of_it} says: {what}"
            elif order == 0:
                yield f"{of_it} does not belong to it: {_size(found)}; are columns swapped, stuck or in other units?"


def remarks(rows: RecordedRows, coordinates: Sequence[Coordinate]) -> Iterator[str]:
    """Lines for what may be right and deserves a look."""
    q, qd, time, episode = rows.q, rows.qd, rows.time, rows.episode
    step = float(np.median(np.diff(time)[episode[1:] == episode[:-1]])) if len(time) > 1 else 0.0
    if not FAST <= step <= SLOW:
        yield f"the sampling interval is {step:.3g} s: is the time in seconds (data.units.time)?"
    for k, coordinate in enumerate(coordinates):
        if np.ptp(q[:, k]) == 0:
            yield f"{coordinate.name} never changes"
        if coordinate.is_angle and np.abs(q[:, k] - q[0, k]).max() > LARGE_ANGLE:
            turns = np.abs(q[:, k] - q[0, k]).max() / (2 * math.pi)
            yield f"{coordinate.name} moves by {turns:.1f} turns: is it in degrees (data.units.q)?"
        found = None if qd is None else agreement(q[:, k], qd[:, k], time, episode)
        if found is None or found.unexplained > CONTRADICTS:
            continue
        if found.unexplained > AGREES:
            yield f"the velocity of {coordinate.name} fits it only roughly: {_size(found)}"
        elif found.first_wrong is not None:
            yield (
                f"{coordinate.name} and its velocity disagree from data row {rows.row[found.first_wrong] + 1} on: is a "
                "value stuck, or are samples missing?"
            )


def _size(found: Agreement) -> str:
    share = "all" if found.unexplained > 1 else f"{found.unexplained:.0%}"
    return f"its integral leaves {share} of the motion unexplained"
