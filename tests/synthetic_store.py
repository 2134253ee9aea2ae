"""A store with known answers: written by hand after the store's layout, no run needed."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

BASE_CARD: Mapping[str, Any] = {
    "system": "sip",
    "reading": "physical",
    "regime": "episodes",
    "labels": "exact",
    "noise": "none",
    "model": "lagrangian",
    "basis": "t2",
    "hidden": "10",
    "objective": "inverse",
    "optimiser": "adam",
    "sequence": "main",
    "grid": None,
    "pretraining_epochs": None,
    "reset": "start",
    "tau_noise": 0.0,
    "qdd_noise": 0.0,
    "damping": [0.0, 0.0],
    "n_train": 80000,
    "episode_steps": 1000,
    "energies": "raw",
    "energy_form": "legendre",
    "momentum_weight": 0.0,
    "momentum_hidden": "",
    "curriculum": None,
    "epochs": 5000,
    "literal": True,
}


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
        **card: Any,
    ) -> str:
        n = max((len(values) for values in metrics.values()), default=len(seeds or [0]))
        seeds = list(range(n)) if seeds is None else list(seeds)
        self.count += 1
        name = f"sip-run-{self.count:010x}"
        folder = self.outputs / "runs" / ("" if outcome == "ok" else ".failed") / name
        folder.mkdir(parents=True)
        full = {**BASE_CARD, **card, "seeds": seeds, "member_status": list(status or ["ok"] * n)}
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
            "summary": {"card": full} if outcome == "ok" else {},
            "provenance": {},
            "files": {},
            "error": None if outcome == "ok" else {"type": "MemoryError", "message": "no room", "command": ""},
        }
        (folder / "run.json").write_text(json.dumps(record), encoding="utf-8")
        overrides = [f"{key}={value}" for key, value in card.items()] + [f"seeds={seeds}"]
        job = {"overrides": overrides, "run": name, "command": f"repro run {' '.join(overrides)}"}
        self.list_job(experiment, job if outcome == "ok" else {**job, "card": full})
        return name

    def anchors(
        self, experiment: str, *, trivial: Mapping[str, float], degenerate: Mapping[str, float], **card: Any
    ) -> None:
        literal = {"literal": False, "hidden": "", "epochs": 0} | card
        basis = literal.pop("basis", "t1")
        self.run(experiment, {k: [v] for k, v in trivial.items()}, model="trivial", basis="", optimiser="", **literal)
        self.run(
            experiment, {k: [v] for k, v in degenerate.items()}, model="degenerate", basis="", optimiser="", **literal
        )
        exact = {key: [1e-13, 2e-13] for key in trivial}
        self.run(experiment, exact, basis=basis, optimiser="least_squares", **literal)

    def bench(self, rows: Sequence[Mapping[str, Any]], *, experiment: str = "timing") -> str:
        self.count += 1
        name = f"bench-{self.count:010x}"
        folder = self.outputs / "bench" / name
        folder.mkdir(parents=True)
        pd.DataFrame(list(rows)).to_parquet(folder / "bench.parquet")
        record = {"id": name, "kind": "bench", "outcome": "ok", "provenance": {"command": "repro bench"}}
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
