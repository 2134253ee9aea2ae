"""Stored runs as tidy tables, and how two runs differ."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from repro.errors import UserError
from repro.tracking.load import load_runs, load_stage
from repro.tracking.stage import Stage
from repro.tracking.stage_difference import record_differences


@pytest.fixture
def two_runs(store, toy):
    """Two runs that differ in the epochs of their fit; an experiment lists the first."""
    records = []
    for epochs, error in ((10, 0.5), (20, 0.25)):
        stages = toy.stages(epochs=epochs)
        for role in ("data", "fit"):
            store.compute(stages[role], lambda folder: {})

        def work(folder, error=error, epochs=epochs):
            rows = [(m, "test", name, error + m, "N") for m in range(2) for name in ("mae_tau", "mae_qdd")]
            table = pd.DataFrame(rows, columns=["member", "split", "metric", "value", "unit"])
            table.to_parquet(folder / "metrics.parquet")
            return {"card": {"system": "toy", "epochs": epochs, "seeds": [0, 1]}, "median": {"mae_tau": error}}

        records.append(store.compute(stages["score"], work))
    file = store.paths.experiments / "quick" / "basis.json"
    file.parent.mkdir(parents=True)
    jobs = [{"overrides": [], "command": "", "run": records[0].id}]
    file.write_text(json.dumps({"experiment": "basis", "scale": "quick", "jobs": jobs}))
    return records


def test_load_runs_is_tidy(two_runs):
    table = load_runs()
    assert list(table.columns[:3]) == ["run", "experiment", "scale"]
    assert len(table) == 8
    assert set(table["system"]) == {"toy"}
    assert table.groupby("epochs")["value"].mean().to_dict() == {10: 1.0, 20: 0.75}


def test_load_runs_filters(two_runs):
    assert set(load_runs(experiment="basis", scale="quick")["run"]) == {two_runs[0].id}
    assert set(load_runs(epochs=[20, 30])["run"]) == {two_runs[1].id}
    assert set(load_runs(metric="mae_tau")["metric"]) == {"mae_tau"}
    assert len(load_runs(value=lambda value: value > 1)) == 4
    with pytest.warns(UserWarning, match="no run has epochs=99; there are 10, 20"):
        assert load_runs(epochs=99).empty
    with pytest.raises(UserError, match="no column epoch to filter by; there are: run, experiment"):
        load_runs(epoch=10)


def test_load_runs_of_nothing(root):
    assert load_runs().empty


def test_load_run(two_runs, toy):
    run = load_stage(two_runs[0].id[-10:])
    assert run.id == two_runs[0].id
    assert len(run.table("metrics")) == 4
    assert run.upstream["fit"].identity.config == {"epochs": 10}
    assert run.upstream["fit"].upstream["data"].identity.config == {"samples": 100}
    with pytest.raises(UserError, match="has no table curves; it has: metrics"):
        run.table("curves")
    run.path("run.json").write_text("{}")
    with pytest.raises(UserError, match="is damaged"):
        load_stage(run.id)


def test_differences_reach_upstream_and_results(store, two_runs, toy):
    found = record_differences(store, *two_runs)
    lines = {f"{one.area} | {one}" for one in found}
    assert "fit: config | fit: config epochs: 10 -> 20" in lines
    assert "results | results card.epochs: 10 -> 20" in lines
    assert "results | results median.mae_tau: 0.5 -> 0.25" in lines
    assert record_differences(store, two_runs[0], two_runs[0]) == []


def test_changed_code_is_a_difference(store, toy):
    def make():
        stage = Stage("fits", "toy", {}, {}, (f"{toy.name}.learning.fit",))
        return store.compute(stage, lambda folder: {})

    before = make()
    toy.edit("learning/loss.py", "**2", "**4")
    (one,) = record_differences(store, before, make())
    assert str(one) == f"module {toy.name}.learning.loss changed"
