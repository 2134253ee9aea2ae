"""Small runs of everything that can be chosen: every number they give is the stored one.

This is what a change of structure is held against: it may move code and rename options, but it changes no number.
`cases.yaml` holds the runs as a user types them, `values.csv` their numbers. What takes time is left out.

    python tests/golden/test_golden_results.py --write              store the values of all cases
    python tests/golden/test_golden_results.py --write NAME ...     those of some
    python tests/golden/test_golden_results.py                      compare all, and say how many are equal to the bit

Values come from code that the compiler tunes to the processor (vectors of its width, sums in another order), so another
kind of processor or other versions of the libraries may round differently: if a case fails on code that is known to be
good, store the values there first, then change the code.
"""

import csv
import math
import re
import shlex
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import repro
from repro import __main__ as cli
from repro.results.run_card import RunCard

HERE = Path(__file__).parent
VALUES = HERE / "values.csv"
CASES: dict[str, str] = yaml.safe_load((HERE / "cases.yaml").read_text())
COLUMNS = ("case", "table", "member", "split", "metric", "value")

RELATIVE = 1e-9
# The energies, forces and accelerations of these systems are of the order of 1 to 100: an error below this is what
# rounding leaves of an exact fit, and its digits mean nothing.
ROUNDING = 1e-11
TIMED = re.compile(r"seconds|_ms_")  # what the clock says
SHOWN = 40  # of the values that differ

# (table, member, split, metric) -> value
Key = tuple[str, str, str, str]
Values = dict[Key, float]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_no_number_changes(case: str, tmp_path: Path, record_property: Callable[[str, object], None]) -> None:
    expected = stored()[case]
    got = measured(case, tmp_path)
    equal = sum(same_bits(value, got[key]) for key, value in expected.items() if key in got)
    said = f"{case}: {len(expected)} values, {equal} equal to the bit"
    print(said)
    record_property("equal_to_the_bit", said)
    found = differences(expected, got)
    assert not found, report(case, found)


def test_every_case_has_values_and_all_values_a_case() -> None:
    assert list(stored()) == list(CASES)


def test_a_difference_is_found_and_rounding_is_none() -> None:
    def key(name: str) -> Key:
        return ("metrics", "0", "test", name)

    one = {key("a"): 1.0, key("noise"): 1e-15, key("none"): math.nan, key("far"): math.inf, key("gone"): 2.0}
    two = {key("a"): 1.0 + 1e-10, key("noise"): 3e-14, key("none"): math.nan, key("far"): math.inf, key("new"): 2.0}
    assert [name for (*_, name), _, _ in differences(one, two)] == ["gone", "new"]
    changed = {key("a"): 1.0 + 1e-8, key("noise"): 1e-10, key("none"): 0.0, key("far"): -math.inf, key("gone"): 2.0}
    assert [name for (*_, name), _, _ in differences(one, changed)] == ["a", "noise", "none", "far"]


def measured(case: str, folder: Path) -> Values:
    """Run a case, its results in this folder, and take all its numbers."""
    recording, outputs = folder / "recording.csv", folder / "outputs"
    if "{recording}" in CASES[case]:
        write_recording(recording)
    overrides = shlex.split(CASES[case].replace("{recording}", str(recording)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("REPRO_OUTPUTS", str(outputs))
        code = cli.main(["run", *overrides, "record=false", "--workers", "1"])
        assert code == 0, f"{case}: repro run ended with {code}"
        return dict(numbers(the_run(repro.load_runs()["run"].unique())))


def the_run(ids: Iterable[str]) -> str:
    """The run that was asked for: the parts of a model are runs too, and their weights are among its own."""
    fits = {id: repro.load_run(id).upstream["fit"] for id in ids}
    parts = {part.id for fit in fits.values() for part in fit.upstream.values()}
    (asked,) = (id for id, fit in fits.items() if fit.id not in parts)
    return asked


def write_recording(path: Path) -> None:
    """A recording of nothing in particular, by formula: smooth motion, and forces that a model can fit in part."""
    t = 0.02 * np.arange(400)
    x, theta = 0.4 * np.sin(1.3 * t), 0.9 * np.sin(2.1 * t + 0.5)
    xd, thetad = 0.52 * np.cos(1.3 * t), 1.89 * np.cos(2.1 * t + 0.5)
    force, torque = -1.2 * x + 0.3 * thetad * np.sin(theta), -0.8 * np.sin(theta) - 0.1 * thetad
    columns = {"time": t, "x": x, "theta": theta, "xd": xd, "thetad": thetad, "force": force, "torque": torque}
    # Twelve digits: the sine of another C library differs in the last one.
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.12f")


def numbers(id: str) -> Iterator[tuple[Key, float]]:
    """All numbers of a run: its metrics, its closed loops, and in short its weights and the loops' trajectories."""
    run = repro.load_run(id)
    seen: Counter[Key] = Counter()
    for row in run.table("metrics").itertuples():
        key = ("metrics", str(row.member), row.split, row.metric)
        seen[key] += 1
        # A name that comes twice is numbered, so that none hides another.
        name = row.metric if seen[key] == 1 else f"{row.metric} ({seen[key]})"
        if not TIMED.search(row.metric):
            yield (*key[:3], name), float(row.value)
    for seed, weights in zip(run.seeds, run.parameters.numpy(), strict=True):
        for name, value in summary(weights):
            yield ("parameters", str(seed), "", name), value
    folder = run.folder
    if (folder / "control.parquet").is_file():
        loops = run.table("control").assign(**RunCard.of(run.summary).loop_columns())
        yield from loop_numbers(loops, run.table("closed_loops"))


def loop_numbers(loops: pd.DataFrame, trajectories: pd.DataFrame) -> Iterator[tuple[Key, float]]:
    """Every number of every closed loop, and its trajectories in short: most of its numbers are counts."""
    for number, loop in enumerate(loops.to_dict("records")):
        for name, value in loop.items():
            if isinstance(value, (bool, int, float, np.number)) and name != "member" and not TIMED.search(name):
                yield ("control", str(loop["member"]), f"loop {number}", name), float(value)
    for (number, member, name), points in trajectories.groupby(["loop", "member", "name"], sort=True):
        values = points["value"].to_numpy(float)
        # There is no force at the last point.
        for short, value in summary(values[np.isfinite(values)]):
            yield ("closed_loops", str(member), f"loop {number}", f"{name} {short}"), value


def summary(values: np.ndarray) -> Iterator[tuple[str, float]]:
    """An array in a few numbers, which do not depend on the order of summation."""
    yield "count", float(values.size)
    yield "sum", math.fsum(values.ravel())
    yield "norm", math.sqrt(math.fsum(values.ravel() ** 2))


def differences(expected: Values, got: Values) -> list[tuple[Key, float | None, float | None]]:
    """The keys whose values differ, or are on one side alone, with both values."""
    keys = [*expected, *(key for key in got if key not in expected)]
    pairs = ((key, expected.get(key), got.get(key)) for key in keys)
    return [(key, one, two) for key, one, two in pairs if one is None or two is None or not close(one, two)]


def close(one: float, two: float) -> bool:
    """Equal but for rounding: to RELATIVE of the larger, or both no more than rounding errors themselves."""
    if not (math.isfinite(one) and math.isfinite(two)):
        return one == two or (math.isnan(one) and math.isnan(two))
    larger = max(abs(one), abs(two))
    return abs(one - two) <= RELATIVE * larger or larger <= ROUNDING


def same_bits(one: float, two: float) -> bool:
    return one == two or (math.isnan(one) and math.isnan(two))


def report(case: str, found: list[tuple[Key, float | None, float | None]]) -> str:
    """The first values that differ, a line each."""
    lines = [f"{case}: {len(found)} values differ"]
    for (table, member, split, metric), expected, got in found[:SHOWN]:
        place = " ".join(word for word in (table, split, metric) if word)
        apart = ""
        if expected is not None and got is not None and expected:
            apart = f", relative {abs(got - expected) / abs(expected):.1e}"
        lines.append(f"  {case}, {place}, member {member}: expected {expected}, got {got}{apart}")
    if len(found) > SHOWN:
        lines.append(f"  and {len(found) - SHOWN} more")
    return "\n".join(lines)


def stored() -> dict[str, Values]:
    """The stored values of every case."""
    values: dict[str, Values] = {}
    if VALUES.is_file():
        with VALUES.open(newline="") as file:
            for row in csv.DictReader(file):
                key = (row["table"], row["member"], row["split"], row["metric"])
                values.setdefault(row["case"], {})[key] = float(row["value"])
    return values


def store(values: Mapping[str, Values]) -> None:
    """Write the values in the order of the cases; repr gives a float back to the bit."""
    with VALUES.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for case in CASES:
            writer.writerows((case, *key, repr(value)) for key, value in values.get(case, {}).items())


def main(arguments: Iterable[str]) -> int:
    """Store or compare the values of the named cases, or of all; 1 where some differ."""
    words = list(arguments)
    write = "--write" in words
    names = [word for word in words if word != "--write"] or list(CASES)
    if unknown := set(names) - set(CASES):
        print(f"no case {', '.join(sorted(unknown))}; there are: {', '.join(CASES)}", file=sys.stderr)
        return 2
    before, now, failed = stored(), {}, False
    for case in names:
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            now[case] = measured(case, Path(folder))
        known = before.get(case, {})
        equal = sum(same_bits(value, now[case][key]) for key, value in known.items() if key in now[case])
        seconds = time.monotonic() - started
        print(f"{case}: {len(now[case])} values, {equal} equal to the bit, {seconds:.1f} s", flush=True)
        if known and (found := differences(known, now[case])):
            print(report(case, found), flush=True)
            failed = True
        if write:
            store(before | now)
    return int(failed and not write)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
