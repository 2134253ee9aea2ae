import json

import numpy as np
import pandas as pd
import pytest

from repro.errors import UserError
from repro.results.gather import CURVE_STEPS, Gathering, gather
from repro.results.results import Results
from repro.results.selectors import settings
from repro.results.stored import read_stored
from repro.results.table_schema import TABLES


def test_gathered_tables_have_the_fixed_columns_whatever_the_store_holds(store):
    empty = store.gathered()
    store.run("sip_basis", {"mae_tau": [0.1]})
    filled = store.gathered()
    for name, columns in TABLES.items():
        assert list(getattr(empty, name)) == list(columns)
        assert list(getattr(filled, name)) == list(columns)
        assert dict(getattr(empty, name).dtypes) == dict(getattr(filled, name).dtypes)


def test_every_row_carries_the_card_the_seed_and_the_place(store):
    run = store.run("sip_basis", {"mae_tau": [0.1, 0.2]}, seeds=[7, 9], basis="t1", tau_noise=0.1)
    rows = store.gathered().metrics
    assert rows[["run", "experiment", "scale", "basis"]].drop_duplicates().values.tolist() == [
        [run, "sip_basis", "paper", "t1"]
    ]
    assert rows["member"].tolist() == [7, 9]
    assert rows["tau_noise"].tolist() == [0.1, 0.1]
    assert rows["damping"].tolist() == ["[0, 0]"] * 2


def test_runs_that_differ_in_seeds_alone_are_one_setting(store):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0]}, seeds=[0, 1])
    store.run("sip_basis", {"mae_tau": [3.0, 9.0]}, seeds=[2, 0])  # seed 0 again: counted once
    store.run("sip_basis", {"mae_tau": [50.0]}, seeds=[0], basis="t1")
    pooled, other = settings(store.gathered(), "sip_basis")
    assert pooled.values("mae_tau").tolist() == [1.0, 2.0, 3.0]
    assert other.values("mae_tau").tolist() == [50.0]
    assert len(pooled.commands) == 2


def test_a_run_that_differs_in_a_setting_without_a_column_is_not_pooled(store):
    store.run("sip_basis", {"mae_tau": [1.0]}, seeds=[0])
    store.run("sip_basis", {"mae_tau": [2.0]}, seeds=[1], **{"optimiser.learning_rate": 0.1})
    assert len(settings(store.gathered(), "sip_basis")) == 2


def test_a_run_of_two_experiments_stands_in_both(store):
    run = store.run("sip_basis", {"mae_tau": [1.0]})
    store.list_job("sip_regimes", {"run": run, "command": "repro run", "overrides": []})
    assert store.gathered().metrics["experiment"].tolist() == ["sip_basis", "sip_regimes"]


def test_what_no_experiment_lists_stays_out_such_as_a_run_of_older_code(store):
    listed = store.run("sip_basis", {"mae_tau": [1.0]})
    store.run("", {"mae_tau": [2.0]})
    assert store.gathered().runs["run"].tolist() == [listed]


def test_runs_of_another_scale_stay_out(store):
    store.run("sip_basis", {"mae_tau": [1.0]})
    assert gather(read_stored(store.outputs, "quick")).runs.empty


def test_failed_and_missing_runs_are_rows_with_their_error(store):
    store.run("sip_basis", {}, seeds=[0, 1], outcome="failed")
    store.list_job("sip_basis", {"run": "never-made", "command": "repro run x", "overrides": []})
    runs = store.gathered().runs
    assert runs["outcome"].tolist() == ["failed", "missing"]
    assert runs["error"].tolist() == ["MemoryError: no room", ""]
    assert settings(store.gathered(), "sip_basis") == []


def test_a_run_is_stale_that_is_named_so(store):
    run = store.run("sip_basis", {"mae_tau": [1.0]})
    assert store.gathered(stale={run}).runs["stale"].tolist() == [True]
    assert store.gathered().runs["stale"].tolist() == [False]


def test_long_curves_are_thinned_and_keep_both_ends(store):
    often = pd.DataFrame({"member": 0, "step": range(5000), "name": "loss", "value": 1.0})
    seldom = often[::10].assign(name="min_eig_M")
    store.run("sip_basis", {"mae_tau": [1.0]}, curves=pd.concat([often, seldom]))
    curves = store.gathered().curves
    for name, last in (("loss", 4999), ("min_eig_M", 4990)):
        steps = curves.loc[curves["name"] == name, "step"]
        assert len(steps) == CURVE_STEPS
        assert (steps.min(), steps.max()) == (0, last)


def test_curves_keep_six_digits_of_any_size_and_what_is_not_finite(store):
    values = [1 / 3, -2e143, 4.5e-16, 0.0, np.inf, np.nan]
    curve = pd.DataFrame({"member": 0, "step": range(6), "name": "loss", "value": values})
    store.run("sip_basis", {"mae_tau": [1.0]}, curves=curve)
    np.testing.assert_allclose(store.gathered().curves["value"], values, rtol=1e-6)


def test_only_trajectories_that_a_figure_shows_are_kept(store):
    rows = [{"member": m, "name": "plant.xd", "t": 0.04 * k, "value": 1.0} for m in range(5) for k in range(400)]
    shown = store.run("sip_regimes", {"mae_tau": [1.0] * 5}, trajectories=pd.DataFrame(rows))
    store.run("sip_basis", {"mae_tau": [1.0] * 5}, trajectories=pd.DataFrame(rows))
    kept = store.gathered().trajectories
    assert set(kept["run"]) == {shown}
    assert kept.groupby("member").size().to_dict() == {0: 300, 1: 300, 2: 300}


def test_results_survive_being_saved_and_loaded(store, tmp_path):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0]}, seeds=[3, 4], status=["ok", "diverged at step 5"])
    store.bench([{"name": "forward_vs_inverse", "ratio_median": 1.5}])
    results = store.gathered()
    results.save(tmp_path / "results")
    again = Results.load(tmp_path / "results")
    for name in TABLES:
        pd.testing.assert_frame_equal(getattr(again, name), getattr(results, name))
    assert again.scale == "paper"


def test_a_damaged_file_is_named(store):
    run = store.run("sip_basis", {"mae_tau": [1.0]})
    (store.outputs / "runs" / run / "metrics.parquet").write_bytes(b"no table")
    with pytest.raises(UserError, match=f"{run}/metrics.parquet cannot be read"):
        store.gathered()
    (store.outputs / "runs" / run / "run.json").write_text("{", encoding="utf-8")
    with pytest.raises(UserError, match=r"run\.json cannot be read"):
        store.gathered()


def test_a_folder_without_results_is_an_error(tmp_path):
    with pytest.raises(UserError, match="holds no metrics"):
        Results.load(tmp_path)


def test_a_card_of_the_wrong_type_is_named(store):
    run = store.run("sip_basis", {"mae_tau": [1.0]}, epochs="many")
    with pytest.raises(UserError, match=rf"{run}/run\.json has a run card of the wrong type"):
        store.gathered()


def test_what_is_as_printed_is_judged_anew_at_each_gathering(store):
    store.run("sip_basis", {"mae_tau": [1.0]}, tau_noise=0.1)
    protocols = {"noisy": {"data.tau_noise": 0.1}, "another": {"data.tau_noise": 0.2}}
    for paper, expected in ((Gathering(protocols), True), (Gathering({"another": protocols["another"]}), False)):
        assert gather(read_stored(store.outputs, "paper"), paper).runs["as_printed"].tolist() == [expected]


def test_a_run_is_followed_back_to_its_data(store):
    name = store.run("sip_basis", {"mae_tau": [0.2]})
    run = store.outputs / "runs" / name / "run.json"
    record = json.loads(run.read_text(encoding="utf-8"))
    record["identity"]["upstream"] = {"data": "sip-data", "fit": "sip-fit"}
    run.write_text(json.dumps(record), encoding="utf-8")
    for kind, id, upstream in (("data", "sip-data", {}), ("fits", "sip-fit", {"data": "sip-data"})):
        origin = {"wall_s": 2.5, "git": {"commit": "abc", "clean": True}, "machine": {"cores_allowed": 2}}
        identity = {"upstream": upstream, "config": {"seeds": [0]}}
        made = {"id": id, "kind": kind, "name": "sip", "outcome": "ok", "identity": identity, "provenance": origin}
        made |= {"summary": {}, "files": {}, "error": None}
        (store.outputs / kind / id).mkdir(parents=True)
        (store.outputs / kind / id / "run.json").write_text(json.dumps(made), encoding="utf-8")

    stages = store.gathered().stages

    assert list(stages["stage"]) == ["data", "fit", "evaluation"]
    assert list(stages["id"]) == ["sip-data", "sip-fit", name]
    fit = stages.set_index("stage").loc["fit"]
    assert (fit["wall_s"], fit["commit"], bool(fit["clean"]), fit["cores"]) == (2.5, "abc", True, 2)
    assert json.loads(fit["config"]) == {"seeds": [0]}


def test_a_source_that_is_gone_is_left_out(store):
    name = store.run("sip_basis", {"mae_tau": [0.2]})
    run = store.outputs / "runs" / name / "run.json"
    record = json.loads(run.read_text(encoding="utf-8"))
    record["identity"]["upstream"] = {"data": "swept-away"}
    run.write_text(json.dumps(record), encoding="utf-8")
    assert list(store.gathered().stages["stage"]) == ["evaluation"]
