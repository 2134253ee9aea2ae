"""Writes the numbers of docs/measured-data.md that the published runs and timings give.

python docs/measured.py           write them again, from paper/results
python docs/measured.py --check   exit with 1 when they are out of date
"""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pandas as pd
from generated import write_or_check

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "paper" / "results"
PAGE = ROOT / "docs" / "measured-data.md"
BASES = {"sip": "T1", "dip": "F⊗F"}
SENSORS = ("measured", "sample_step", "q_noise", "qd_noise", "force_noise", "quantisation")
SCENARIOS = {  # as in experiments/measured.yaml
    "A": ("states", None, 0.0, 0.0, 0.0, []),
    "B": ("states", None, 1e-3, 1e-2, 0.0, []),
    "C": ("positions", 0.01, 0.0, 0.0, 0.0, [1e-4, 1.534e-3]),
    "D": ("positions", 0.01, 1e-3, 0.0, 0.0, []),
    "E": ("positions", None, 1e-3, 0.0, 0.0, []),
    "F": ("states", None, 1e-3, 1e-2, 0.1, []),
}
METHODS = {  # title of a column -> labels and objective
    "Savitzky-Golay": ("savitzky_golay", "inverse"),
    "balance": ("smoothed", "balance"),
    "path": ("smoothed", "path"),
}
ZERO = 0.02  # rad, of the encoder in the runs with friction


class Runs:
    """The published runs of experiment=measured: their settings, and the values of their members."""

    def __init__(self, results: Path) -> None:
        own = [("experiment", "==", "measured")]
        columns = ["run", "system", "model", "objective", "labels", "config"]
        self.cards = pd.read_parquet(results / "runs.parquet", columns=columns, filters=own)
        self.cards["config"] = self.cards["config"].map(json.loads)
        values = pd.read_parquet(results / "metrics.parquet", columns=["run", "split", "metric", "value"], filters=own)
        self.values = values[(values["split"] == "test") | ~values["metric"].str.startswith("mae_")]

    def of(self, run: str, metric: str) -> pd.Series:
        """The values of the members of a run."""
        return self.values[(self.values["run"] == run) & (self.values["metric"] == metric)]["value"]

    def one(self, config: Mapping[str, object], **card: str) -> str:
        """The run with these cells of its card and its configuration. Raises ValueError unless there is one."""
        rows = self.cards[(self.cards[list(card)] == pd.Series(card)).all(axis=1)]
        pairs = zip(rows["run"], rows["config"], strict=True)
        found = [run for run, own in pairs if all(own.get(key) == value for key, value in config.items())]
        if len(found) != 1:
            raise ValueError(f"{len(found)} runs of experiment=measured have {card} and {dict(config)}, not one")
        return str(found[0])


def sensors(scenario: str, zero: float) -> dict[str, object]:
    """The keys of the configuration that a scenario stands for, with the zero of the encoder in rad."""
    keys = {**dict(zip(SENSORS, SCENARIOS[scenario], strict=True)), "train_samples": None, "encoder_zero": zero}
    return {f"data.{key}": value for key, value in keys.items()}


def rows(runs: Runs) -> Iterator[Sequence[str]]:
    """Cells of the table: linear bases, then networks, which have fewer methods and scenarios."""
    for system, basis in BASES.items():
        for scenario in SCENARIOS:
            yield basis, *_row(runs, scenario, METHODS, system=system, model="lagrangian")
    methods = {title: METHODS[title] for title in ("balance", "path")}
    for scenario in ("B", "D"):
        yield "network", *_row(runs, scenario, methods, system="sip", model="structured")


def _row(runs: Runs, scenario: str, methods: Mapping[str, tuple[str, str]], **card: str) -> Sequence[str]:
    chosen = {
        title: runs.one(sensors(scenario, 0.0), labels=labels, objective=objective, **card)
        for title, (labels, objective) in methods.items()
    }
    path = chosen["path"]
    errors = [shown(runs.of(chosen[title], "mae_qdd").median()) if title in chosen else "" for title in METHODS]
    rest = runs.of(path, "mae_qdd").max(), runs.of(path, "bound_mae_qdd").median(), runs.of(path, "fit_seconds").max()
    return scenario, *errors, *map(shown, rest), str(len(runs.of(path, "fit_seconds")))


def still(runs: Runs, system: str) -> float:
    """The mean of abs(qdd), which a model of no motion has as its error."""
    run = runs.one(sensors("A", 0.0), system=system, labels="smoothed", objective="balance")
    mean: float = (runs.of(run, "mae_qdd") / (1 - runs.of(run, "skill_qdd").to_numpy())).median()
    return mean


def numbers(runs: Runs, race: pd.Series) -> str:
    """The lines of the page; race: the timing against a neural ODE."""
    titles = ("model", "recorded", *METHODS, "path, worst", "bound", "path, s at most", "seeds")
    table = "".join(f"| {' | '.join(cells)} |\n" for cells in (titles, ["---"] * len(titles), *rows(runs)))
    without, known = (
        runs.one(sensors("D", ZERO) | {"objective.path.zeros": zeros}, system="sip") for zeros in ("none", "angles")
    )
    before, after = (shown(runs.of(run, "cost_per_dof").median()) for run in (without, known))
    friction = shown(100 * max(runs.of(known, f"damping_error[{joint}]").max() for joint in (0, 1)))
    zeros = runs.of(known, "encoder_zero[0]")
    off = shown(1e3 * (zeros - ZERO).abs().max())
    seconds, starts = shown(race["ours_ms"] / 1e3), race["starts"]
    reached = int(race["other_reached"]) or "none"
    return f"""\
{table}
The mean |q̈| is {shown(still(runs, "sip"))} (T1) and {shown(still(runs, "dip"))} (F⊗F).

With a viscous friction of 0.3 N s/m and 0.002 N m s/rad, and an encoder that is 20 mrad off and counts no turns (D, T1,
`model.damping=diagonal objective.path.zeros=angles`), the coefficients of friction are found within {friction} % and
the zero within {off} mrad, by the worst of {len(zeros)} seeds. Without `zeros` the cost per degree of freedom is
{before} instead of {after}: the alarm that something is missing.

A neural ODE with the same network (`structured`) and starts, fitted by Adam to roll-outs of 5 steps (2,000 samples of
B): the path fit takes {seconds} s, the median of {starts} starts, and Adam reaches its error in {reached} of them
within ten times its seconds.
"""


def shown(value: float) -> str:
    """A number with two digits."""
    rounded = float(f"{value:.2g}")
    return f"{rounded:.1e}".replace("e-0", "e-") if 0 < abs(rounded) < 1e-3 else f"{rounded:g}"


def main(arguments: Sequence[str]) -> int:
    """Write the page, or check it."""
    timings = pd.read_parquet(
        RESULTS / "bench.parquet",
        columns=["name", "starts", "ours_ms", "other_reached"],
        filters=[("name", "==", "path")],
    )
    return write_or_check(PAGE, "measured", numbers(Runs(RESULTS), timings.iloc[0]), arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
