"""Writes the tables of docs/related-work.md: the error of each method in each regime, and its closed loops.

python docs/regimes.py           write the tables again, from paper/results
python docs/regimes.py --check   exit with 1 when they are out of date
"""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from generated import write_or_check

from repro.report.tables.models import BUDGET, UNDER_TRAINED, training_of
from repro.report.writing import ABSENT, interval, number
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import Where, find_loops, settings
from repro.results.statistics import share

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "related-work.md"
RESULTS = ROOT / "paper" / "results"
EXPERIMENT = "related_work"
BUDGET_S, SAMPLES, MORE_SAMPLES = 5.0, 1000, (300, 1000, 10000)

SYSTEMS = {
    "sip": "Cart-pole",
    "dip": "Double pendulum on a cart",
    "torque_pendulum": "Torque pendulum",
    "acrobot": "Acrobot",
}
BY_TIME = {"optimiser": "adam_budget"}
DELAN = {"model": "structured", **BY_TIME}
OURS = {"model": "structured", "optimiser": "levenberg_marquardt"}
CLOSED = {"basis": ["t1", "fxf"], "optimiser": "least_squares"}
ANCHORS: Mapping[str, Where] = {"trivial": {"model": "trivial"}, "degenerate": {"model": "degenerate"}}
PEER_NETWORKS: Mapping[str, Where] = {
    "MLP": {"model": "blackbox", "objective": "forward", **BY_TIME},
    "neural ODE": {"model": "blackbox", "objective": "prediction", **BY_TIME},
    "LNN": {"basis": "engineered", **BY_TIME},
    "DeLaN": {**DELAN, "objective": "inverse"},
    "DeLaN with energy": {**DELAN, "objective": "mixed"},
    "HNN, p given": {"model": "hamiltonian", "model.dissipation": "none", **BY_TIME},
    "port-HNN, p given": {"model": "hamiltonian", "model.dissipation": "constant", **BY_TIME},
    "SymODEN": {"model": "symoden", "model.dissipation": "none", **BY_TIME},
    "dissipative SymODEN": {"model": "symoden", "model.dissipation": "state", **BY_TIME},
}
SPARSE: Mapping[str, Where] = {
    "SINDy": {"model": "sparse", "model.form": "explicit"},
    "SINDy-PI": {"model": "sparse", "model.form": "implicit"},
    "sparse L": {"basis": "library"},
}
OUR_NETWORKS: Mapping[str, Where] = {
    "ours, network": {**OURS, "objective": "inverse"},
    "ours, network, balance": {**OURS, "objective": "balance"},
    "ours, network, path": {**OURS, "objective": "path"},
}
CLOSED_FORMS: Mapping[str, Where] = {
    "closed form": {**CLOSED, "objective": "inverse"},
    "closed form, balance": {**CLOSED, "objective": "balance"},
    "closed form, path": {**CLOSED, "objective": "path"},
}
METHODS = {**ANCHORS, **PEER_NETWORKS, **SPARSE, **OUR_NETWORKS, **CLOSED_FORMS}
STATES, FINE = {"data.measured": "states"}, {"data.sample_step": 0.01}
REGIMES: Mapping[str, Where] = {
    "exact": {"data.labels": "exact", "data.tau_noise": 0.0},
    "force noise": {"data.labels": "exact", "data.tau_noise": 0.1},
    "states, 25 Hz": {**STATES, "data.sample_step": ""},
    "states, 100 Hz": {**STATES, **FINE},
    "positions, 100 Hz": {"data.measured": "positions", **FINE},
}
UNDER_TRAINED_MARK = "†"
LOOPS = {**PEER_NETWORKS, **OUR_NETWORKS, **CLOSED_FORMS}
LOOP_REGIMES = ("exact", "states, 25 Hz")


Column = Mapping[str, RunSetting]


def tables(results: Results) -> str:
    """The lines of the page between its marks."""
    parts = [_regimes(results, system) for system in SYSTEMS]
    return "\n".join([*parts, _samples(results), _published_steps(results), _loops(results)])


def _regimes(results: Results, system: str) -> str:
    of_system = {"system": system, "n_train": SAMPLES}
    columns = {name: _column(results, {**of_system, **where}) for name, where in REGIMES.items()}
    return _table(SYSTEMS[system], columns, settings(results, EXPERIMENT))


def _samples(results: Results) -> str:
    columns = {
        f"{SYSTEMS[system]}, {n}": _column(results, {"system": system, "n_train": n, **REGIMES["exact"]})
        for system in ("sip", "dip")
        for n in MORE_SAMPLES
    }
    several = {method for name, column in columns.items() if not name.endswith(str(SAMPLES)) for method in column}
    columns = {name: {key: column[key] for key in column if key in several} for name, column in columns.items()}
    return _table("exact, training samples", columns, settings(results, EXPERIMENT))


def _column(results: Results, where: Where) -> Column:
    """The settings of one column, by method: with the one budget where a method has a budget."""
    found: dict[str, RunSetting] = {}
    for method, of_method in METHODS.items():
        chosen = settings(results, EXPERIMENT, {**where, **of_method, "control": ""})
        chosen = [each for each in chosen if each.settings.get(BUDGET) in (None, BUDGET_S)]
        if len(chosen) > 1:
            raise ValueError(f"{method} with {where}: {len(chosen)} settings, where a cell of the table holds one")
        if chosen:
            found[method] = chosen[0]
    return found


def _table(title: str, columns: Mapping[str, Column], known: Sequence[RunSetting]) -> str:
    """Medians over the seeds, the smallest of a column in bold, the anchors aside; a row of ratios below."""
    rows = [f"| {title} | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    best = [_least(column, set(column) - set(ANCHORS)) for column in columns.values()]
    for method in METHODS:
        of_row = [column.get(method) for column in columns.values()]
        cells = [_cell(setting, least, known) for setting, least in zip(of_row, best, strict=True)]
        if set(cells) != {ABSENT}:
            rows.append(f"| {method} | {' | '.join(cells)} |")
    ratios = [number(_least(column, PEER_NETWORKS) / _least(column, OUR_NETWORKS)) for column in columns.values()]
    rows.append(f"| *best network of a peer / of ours* | {' | '.join(ratios)} |")
    return "\n".join(rows) + "\n"


def _cell(setting: RunSetting | None, least: float, known: Sequence[RunSetting]) -> str:
    if setting is None:
        return ABSENT
    error = _median(setting)
    text = f"**{number(error)}**" if error == least else number(error)
    return text + UNDER_TRAINED_MARK * (training_of(setting, known) == UNDER_TRAINED)


def _median(setting: RunSetting) -> float:
    return setting.estimate("mae_qdd").median


def _least(column: Column, methods: Iterable[str]) -> float:
    return min((_median(column[method]) for method in methods if method in column), default=math.nan)


def _published_steps(results: Results) -> str:
    """What the peers reach with the number of steps of their papers."""
    rows = []
    for method, where in PEER_NETWORKS.items():
        for system in ("sip", "dip"):
            for each in settings(results, EXPERIMENT, {**where, "system": system, "optimiser": "adam"}):
                cells = str(each.card["epochs"]), number(each.estimate("fit_seconds").median), number(_median(each))
                rows.append(f"| {method} | {SYSTEMS[system]} | {' | '.join(cells)} |\n")
    if not rows:
        return "The published numbers of steps were not run.\n"
    return f"""\
| published number of steps | system | epochs | CPU s | MAE q̈ |
|---|---|---|---|---|
{"".join(rows)}"""


def _loops(results: Results) -> str:
    """The share of successful swing-ups, with one share per seed as the unit."""
    rows = []
    for method, where in LOOPS.items():
        cells = [_success(results, {**where, **REGIMES[regime]}) for regime in LOOP_REGIMES]
        if set(cells) != {ABSENT}:
            rows.append(f"| {method} | {' | '.join(cells)} |\n")
    return f"""\
| swing-up of the cart-pole | {" | ".join(LOOP_REGIMES)} |
|---|---|---|
{"".join(rows)}"""


def _success(results: Results, where: Where) -> str:
    loops = find_loops(results, EXPERIMENT, where)
    return interval(share(loops.groupby("member")["success"].mean().to_numpy())) if len(loops) else ABSENT


def main(arguments: Sequence[str]) -> int:
    """Write the page, or check it."""
    return write_or_check(PAGE, "regimes", tables(Results.load(RESULTS)), arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
