"""A store with known answers: written by hand after the store's layout, no run needed."""

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.results.columns import RUN
from repro.results.gather import Gathering, gather
from repro.results.results import Results
from repro.results.run_card import MEASURED
from repro.results.stored import read_stored

# Columns of a run card, and further settings by dotted key.
BASE: Mapping[str, Any] = {
    "system": "sip",
    "reading": "physical",
    "regime": "episodes",
    "labels": "exact",
    "model": "lagrangian",
    "basis": "t2",
    "hidden": "10",
    "objective": "inverse",
    "optimiser": "adam",
    "sequence": "main",
    "reset": "start",
    "tau_noise": 0.0,
    "qdd_noise": 0.0,
    "damping": [0.0, 0.0],
    "n_train": 80000,
    "episode_steps": 1000,
    "energies": "raw",
    "energy_form": "legendre",
    "momentum_weight": 0.0,
    "curriculum": [],
    "epochs": 5000,
}
LAYERS = ("hidden", "momentum_hidden")
# What the synthetic paper prints, and the motions that the figures of the project show.
PAPER = Gathering(
    protocols={"synthetic": {"synthetic.as_printed": True}},
    trajectories={"sip_regimes": {}, "ph_passivity": {}, "measured": {}},
    closed_loops=("sip_control", "dip_control", "swing_up"),
)


def settings_of(card: Mapping[str, Any]) -> dict[str, Any]:
    """The settings by dotted key that columns of the run card would show."""
    settings: dict[str, Any] = {}
    for name, value in card.items():
        if value in (None, ""):
            continue
        if name == "grid":
            settings["sequence.grid"], settings["sequence.initial_angles"] = str(value).split(" of ")
        elif name in LAYERS:
            layers, _, units = value.rpartition("x")
            settings[RUN[name].keys[0]] = [int(units)] * int(layers or 1)
        else:
            settings[RUN[name].keys[0] if name in RUN else name] = value
    return settings


class SyntheticStore:
    """Writes runs as the pipeline does; metrics are given as {name: one value a member}."""

    def __init__(self, outputs: Path, scale: str) -> None:
        self.outputs = outputs
        self.scale = scale
        self.jobs: dict[str, list[dict[str, Any]]] = {}
        self.count = 0

    def run(
        self,
        experiment: str,
        metrics: Mapping[str, Sequence[float]],
        *,
        seeds: Sequence[int] | None = None,
        status: Sequence[str] | None = None,
        outcome: str = "ok",
        curves: pd.DataFrame | None = None,
        trajectories: pd.DataFrame | None = None,
        identifiability: pd.DataFrame | None = None,
        control: pd.DataFrame | None = None,
        closed_loops: pd.DataFrame | None = None,
        as_printed: bool = True,
        **card: Any,
    ) -> str:
        n = max((len(values) for values in metrics.values()), default=len(seeds or [0]))
        seeds = list(range(n)) if seeds is None else list(seeds)
        self.count += 1
        name = f"sip-run-{self.count:010x}"
        folder = self.outputs / "runs" / ("" if outcome == "ok" else ".failed") / name
        folder.mkdir(parents=True)
        whole = {**BASE, **card}
        described = {
            "settings": {**settings_of(whole), "synthetic.as_printed": as_printed},
            "changed": [name for name in card if "." in name],
            "card": {name: whole[name] for name in MEASURED}
            | {"seeds": seeds, "member_status": list(status or ["ok"] * n)},
        }
        rows = [
            {"member": seed, "split": _split(metric), "metric": metric.partition("@")[0], "value": value, "unit": "u"}
            for metric, values in metrics.items()
            for seed, value in zip(seeds, values, strict=False)
        ]
        if outcome == "ok":
            pd.DataFrame(rows, columns=["member", "split", "metric", "value", "unit"]).to_parquet(
                folder / "metrics.parquet"
            )
            beside = {"curves": curves, "trajectories": trajectories, "identifiability": identifiability}
            beside |= {"control": control, "closed_loops": closed_loops}
            for table, content in beside.items():
                if content is not None:
                    content.to_parquet(folder / f"{table}.parquet")
        record = {
            "id": name,
            "kind": "runs",
            "name": "sip-run",
            "outcome": outcome,
            "identity": {"config": {}, "upstream": {}, "code": {"repro.models": "1"}, "libraries": {}},
            "summary": described if outcome == "ok" else {},
            "provenance": {},
            "files": {},
            "error": None if outcome == "ok" else {"type": "MemoryError", "message": "no room", "command": ""},
        }
        (folder / "run.json").write_text(json.dumps(record), encoding="utf-8")
        overrides = [f"{key}={value}" for key, value in card.items()] + [f"seeds={seeds}"]
        job = {"overrides": overrides, "run": name, "command": f"repro run {' '.join(overrides)}"}
        known = {key: described[key] for key in ("settings", "changed")}
        self.list_job(experiment, job if outcome == "ok" else {**job, **known})
        return name

    def gathered(self, stale: Collection[str] = ()) -> Results:
        """The tables of its runs."""
        return gather(read_stored(self.outputs, self.scale, stale), PAPER)

    def anchors(
        self, experiment: str, *, trivial: Mapping[str, float], degenerate: Mapping[str, float], **card: Any
    ) -> None:
        own = {"as_printed": False, "hidden": "", "epochs": 0} | card
        basis = own.pop("basis", "t1")
        self.run(experiment, {k: [v] for k, v in trivial.items()}, model="trivial", basis="", optimiser="", **own)
        self.run(experiment, {k: [v] for k, v in degenerate.items()}, model="degenerate", basis="", optimiser="", **own)
        exact = {key: [1e-13, 2e-13] for key in trivial}
        self.run(experiment, exact, basis=basis, optimiser="least_squares", **own)

    def bench(self, rows: Sequence[Mapping[str, Any]], *, experiment: str = "timing") -> str:
        self.count += 1
        name = f"bench-{self.count:010x}"
        folder = self.outputs / "bench" / name
        folder.mkdir(parents=True)
        pd.DataFrame(list(rows)).to_parquet(folder / "bench.parquet")
        record = {"id": name, "kind": "bench", "name": "timing", "outcome": "ok", "error": None}
        record |= {"identity": {}, "summary": {}, "provenance": {"command": "repro bench"}, "files": {}}
        (folder / "run.json").write_text(json.dumps(record), encoding="utf-8")
        self.list_job(experiment, {"overrides": [], "run": name, "command": "repro bench"})
        return name

    def list_job(self, experiment: str, job: Mapping[str, Any]) -> None:
        if not experiment:
            return
        self.jobs.setdefault(experiment, []).append(dict(job))
        path = self.outputs / "experiments" / self.scale / f"{experiment}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        content = {"experiment": experiment, "scale": self.scale, "jobs": self.jobs[experiment]}
        path.write_text(json.dumps(content), encoding="utf-8")


def _split(metric: str) -> str:
    if metric.endswith("@free"):
        return "free"
    of_training = ("fit_seconds", "rank", "condition_raw", "condition_scaled", "passivity_margin_worst")
    return "train" if metric in of_training else "test"
