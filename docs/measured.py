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
PENDULUMS = {"sip": "single", "dip": "double"}
COORDINATES = {"sip": 2, "dip": 3}
SENSORS = ("measured", "sample_step", "q_noise", "qd_noise", "force_noise", "quantisation")
SCENARIOS = {  # as in experiments/measured.yaml
    "A": ("states", None, 0.0, 0.0, 0.0, []),
    "B": ("states", None, 1e-3, 1e-2, 0.0, []),
    "C": ("positions", 0.01, 0.0, 0.0, 0.0, [1e-4, 1.534e-3]),
    "D": ("positions", 0.01, 1e-3, 0.0, 0.0, []),
    "E": ("positions", None, 1e-3, 0.0, 0.0, []),
    "F": ("states", None, 1e-3, 1e-2, 0.1, []),
}
OF_NETWORKS = OF_ESTIMATES = ("B", "D")
METHODS = {  # title of a column -> labels and objective
    "Savitzky-Golay": ("savitzky_golay", "inverse"),
    "balance": ("smoothed", "balance"),
    "path": ("smoothed", "path"),
}
PATH_TITLES = ("path, worst", "bound", "path, s", "seeds")
LINEAR_TITLES = ("model", "recorded", *METHODS, *PATH_TITLES)
NETWORK_TITLES = (
    *("pendulum", "recorded", "balance", "path", *PATH_TITLES, "cost per degree of freedom, worst", "trapped"),
)
ZERO = 0.02  # rad, of the encoder in the runs with friction


class Runs:
    """The published runs of experiment=measured: their settings, the values of their members, their closed loops."""

    def __init__(self, results: Path) -> None:
        own = [("experiment", "==", "measured")]
        columns = ["run", "system", "model", "objective", "labels", "config"]
        self.cards = pd.read_parquet(results / "runs.parquet", columns=columns, filters=own)
        self.cards["config"] = self.cards["config"].map(json.loads)
        values = pd.read_parquet(results / "metrics.parquet", columns=["run", "split", "metric", "value"], filters=own)
        self.values = values[(values["split"] == "test") | ~values["metric"].str.startswith("mae_")]
        self.loops = pd.read_parquet(results / "control.parquet", columns=["run", "member", "success"], filters=own)

    def of(self, run: str, metric: str) -> pd.Series:
        """The values of the members of a run."""
        return self.values[(self.values["run"] == run) & (self.values["metric"] == metric)]["value"]

    def found(self, config: Mapping[str, object], **card: str) -> str | None:
        """The run with these cells of its card and its configuration, if any. Raises ValueError for several."""
        rows = self.cards[(self.cards[list(card)] == pd.Series(card)).all(axis=1)]
        pairs = zip(rows["run"], rows["config"], strict=True)
        found = [run for run, own in pairs if all(own.get(key) == value for key, value in config.items())]
        if len(found) > 1:
            raise ValueError(f"{len(found)} runs of experiment=measured have {card} and {dict(config)}, not one")
        return str(found[0]) if found else None

    def one(self, config: Mapping[str, object], **card: str) -> str:
        """The run with these cells of its card and its configuration. Raises ValueError unless there is one."""
        found = self.found(config, **card)
        if found is None:
            raise ValueError(f"0 runs of experiment=measured have {card} and {dict(config)}, not one")
        return found

    def path(self, scenario: str, system: str, model: str, noise: str = "given", control: str = "none") -> str | None:
        """The run of a path fit, if it is published."""
        config = sensors(scenario, control=control) | {"objective.path.noise": noise}
        return self.found(config, system=system, model=model, objective="path")


def sensors(scenario: str, zero: float = 0.0, control: str = "none") -> dict[str, object]:
    """The keys of the configuration that a scenario stands for, with the zero of the encoder in rad."""
    keys = {**dict(zip(SENSORS, SCENARIOS[scenario], strict=True)), "train_samples": None, "encoder_zero": zero}
    return {**{f"data.{key}": value for key, value in keys.items()}, "control.name": control}


def linear_rows(runs: Runs) -> Iterator[Sequence[str]]:
    """Cells of the table of linear bases."""
    for system, basis in BASES.items():
        for scenario in SCENARIOS:
            noise: dict[str, object] = {"objective.path.noise": "given"}
            chosen = [
                runs.one(
                    sensors(scenario) | (noise if objective == "path" else {}),
                    system=system, model="lagrangian", labels=labels, objective=objective,
                )
                for labels, objective in METHODS.values()
            ]  # fmt: skip
            medians = [shown(runs.of(run, "mae_qdd").median()) for run in chosen]
            yield basis, scenario, *medians, *_of_path(runs, chosen[-1])


def network_rows(runs: Runs) -> Iterator[Sequence[str]]:
    """Cells of the table of networks; a row whose runs are not published says so."""
    for system, pendulum in PENDULUMS.items():
        for scenario in OF_NETWORKS:
            balance = runs.found(sensors(scenario), system=system, model="structured", objective="balance")
            path = runs.path(scenario, system, "structured")
            if balance is None or path is None:
                yield pendulum, scenario, "not published", *[""] * (len(NETWORK_TITLES) - 3)
                continue
            medians = (shown(runs.of(run, "mae_qdd").median()) for run in (balance, path))
            cost, trapped = runs.of(path, "cost_per_dof").max(), int(runs.of(path, "trapped").sum())
            yield pendulum, scenario, *medians, *_of_path(runs, path), f"{cost:.3f}", str(trapped)


def _of_path(runs: Runs, path: str) -> Sequence[str]:
    errors = runs.of(path, "mae_qdd")
    rest = errors.max(), runs.of(path, "bound_mae_qdd").median(), runs.of(path, "fit_seconds").mean()
    return *map(shown, rest), str(len(errors))


def table(titles: Sequence[str], rows: Iterator[Sequence[str]]) -> str:
    """A table of the page."""
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (titles, ["---"] * len(titles), *rows))


def noise_error(runs: Runs, system: str) -> float | None:
    """The largest relative error of an estimated standard deviation, over scenarios, sensors and seeds.

    None where such a run is not published.
    """
    errors = []
    for scenario in OF_ESTIMATES:
        run = runs.path(scenario, system, "lagrangian", noise="estimated")
        if run is None:
            return None
        measured, _, q_noise, qd_noise, *_ = SCENARIOS[scenario]
        true = [q_noise] * COORDINATES[system] + [qd_noise] * (COORDINATES[system] if measured == "states" else 0)
        errors += [runs.of(run, f"sensor_noise[{i}]") / level - 1 for i, level in enumerate(true)]
    return float(pd.concat(errors).abs().max())


def estimates(runs: Runs) -> str:
    """The sentence on noise levels that are estimated."""
    found = {basis: noise_error(runs, system) for system, basis in BASES.items()}
    known = [f"{shown(100 * error)} % ({basis})" for basis, error in found.items() if error is not None]
    where = f"Noise levels that are estimated from {' and '.join(OF_ESTIMATES)} (`objective.path.noise=estimated`)"
    if len(known) < len(found):
        return f"{where}: not published.\n"
    return f"{where}\nend within {' and '.join(known)} of the true ones, by the worst sensor of the worst seed.\n"


def swing_up(runs: Runs) -> str:
    """The sentence on closed loops with networks."""
    run = runs.path("D", "dip", "structured", control="dip_best")
    what = "The swing-up past the obstacle by the double pendulum's networks from D (`control=dip_best task=random`)"
    if run is None:
        return f"{what}: not published.\n"
    loops = runs.loops[runs.loops["run"] == run]
    return f"""\
{what}
succeeds from {int(loops["success"].sum())} of {len(loops)} random starts, {loops["member"].nunique()} networks in turn.
"""


def still(runs: Runs, system: str) -> float:
    """The mean of abs(qdd), which a model of no motion has as its error."""
    run = runs.one(sensors("A"), system=system, labels="smoothed", objective="balance")
    mean: float = (runs.of(run, "mae_qdd") / (1 - runs.of(run, "skill_qdd").to_numpy())).median()
    return mean


def numbers(runs: Runs, race: pd.Series) -> str:
    """The lines of the page; race: the timing against a neural ODE."""
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
{table(LINEAR_TITLES, linear_rows(runs))}
The mean |q̈| is {shown(still(runs, "sip"))} (T1) and {shown(still(runs, "dip"))} (F⊗F).

Networks with a definite mass matrix (`model=structured`), of 113 weights (single pendulum) and 237 (double pendulum):

{table(NETWORK_TITLES, network_rows(runs))}
{swing_up(runs)}
{estimates(runs)}
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
