"""What an evaluation writes: tables with a row a member, named by its seed."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from repro.evaluation.pointwise import MetricValues
from repro.library.ensemble_model import Ensemble
from repro.models.bases import t1
from repro.models.gauge import Gauge
from repro.models.kinds import blackbox
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.degenerate import Degenerate
from repro.models.kinds.trivial import Trivial
from repro.models.lagrangian import Lagrangian
from repro.pipeline.stages.evaluate import METRICS, TRAJECTORIES, measure

OK = ("ok", "ok")


def _tables(folder):
    return pd.read_parquet(folder / METRICS), pd.read_parquet(folder / TRAJECTORIES)


def test_the_tables_of_an_exact_model(tmp_path, exact):
    summary = measure(tmp_path, exact, Gauge.RAW)
    metrics, trajectories = _tables(tmp_path)
    assert metrics.columns.tolist() == ["member", "split", "metric", "value", "unit"]
    assert not metrics.duplicated(["member", "split", "metric"]).any()
    assert metrics.groupby(["split", "metric"])["member"].agg(set).map(lambda seeds: seeds == {3, 8}).all()
    test = metrics[metrics["split"] == "test"].set_index(["metric", "member"])["value"]
    for name in ("mae_tau", "mae_qdd", "mae_H_centred", "mae_L_canonical", "rollout_error", "coefficient_error"):
        assert test[name].max() < 1e-9
    assert test["support_exact"].min() == 1
    assert summary["median"]["mae_tau"] == pytest.approx(np.median(test["mae_tau"]))
    assert not any("[" in name for name in summary["median"])
    train = metrics[metrics["split"] == "train"].set_index("metric")["value"]
    assert set(train.index) == {"mae_tau", "mae_qdd", "fit_seconds", "epochs", "diverged"}
    assert train["fit_seconds"].tolist() == [0.75, 0.75] and train["epochs"].tolist() == [7, 7]
    assert set(trajectories["member"]) == {3, 8}


def test_trajectories_show_plant_and_model_from_time_zero(tmp_path, exact, data):
    measure(tmp_path, exact, Gauge.RAW)
    table = _tables(tmp_path)[1]
    wide = table[table["member"] == 8].pivot(index="t", columns="name", values="value")
    assert wide.index[0] == 0 and len(wide) == data.test.samples
    for name in ("x", "theta", "xd", "thetad", "T", "V", "H"):
        np.testing.assert_allclose(wide[f"model.{name}"], wide[f"plant.{name}"], atol=1e-8)
    np.testing.assert_array_equal(wide["plant.theta"], data.test.q[1, :, 1])
    for component in range(2):
        np.testing.assert_array_equal(wide[f"tau[{component}]"], data.test.tau[1, :, component])
    np.testing.assert_allclose(wide["plant.H"], wide["plant.T"] + wide["plant.V"])
    assert np.abs(wide["euler.thetad"] - wide["plant.thetad"]).max() > 1e-4


@pytest.mark.parametrize("model", [Trivial(2), Degenerate], ids=["trivial", "degenerate"])
def test_the_anchor_rows_have_metrics_and_no_trajectories(model, tmp_path, data, system):
    model = model if isinstance(model, Trivial) else model(system)
    summary = measure(tmp_path, Ensemble(model, np.zeros((2, 0)), (3, 8), data, OK, system=system), Gauge.RAW)
    metrics, trajectories = _tables(tmp_path)
    assert len(trajectories) == 0 and trajectories.columns.tolist() == ["member", "name", "t", "value"]
    assert summary["median"]["mae_tau"] > 0.1
    assert {"mae_L_raw", "mae_L_canonical", "mae_H_centred"} <= set(metrics["metric"])


def test_a_black_box_has_no_energies(tmp_path, data, system):
    model = BlackBox(2, blackbox.Options(hidden=(3,)))
    weights = model.initial([np.random.default_rng(k) for k in range(2)])
    measure(tmp_path, Ensemble(model, weights, (3, 8), data, OK, system=system), Gauge.RAW)
    metrics, trajectories = _tables(tmp_path)
    names = set(metrics["metric"])
    assert {"mae_qdd", "rollout_error"} <= names and not names & {"mae_tau", "mae_L_raw", "min_eig_M"}
    assert not set(trajectories["name"]) & {"model.H", "plant.H"}


def test_a_diverged_member_is_a_row_like_any_other(tmp_path, data, system):
    """Its mass matrix is singular, its rollout not finite."""
    weights = np.array([[0.4, 0.025, 0.1, 0.98], [0.4, 0.0, 0.0, 0.98]])
    status = ("ok", "diverged at epoch 2")
    measure(tmp_path, Ensemble(Lagrangian(t1, 2), weights, (3, 8), data, status, 1.0, system=system), Gauge.RAW)
    metrics = _tables(tmp_path)[0].set_index(["split", "metric", "member"])["value"]
    assert metrics["train", "diverged", 3] == 0 and metrics["train", "diverged", 8] == 1
    assert metrics["test", "mae_qdd", 3] < 1e-10 and metrics["test", "mae_qdd", 8] == np.inf
    assert metrics["test", "rollout_qd[1]", 8] == np.inf and metrics["test", "rollout_error", 8] > 0.5


def test_unknown_systems_and_short_data_are_measured_as_far_as_possible(tmp_path, exact, data, shortened):
    measure(tmp_path, replace(exact, data=shortened(data, 60, 40), system=None), Gauge.RAW)
    metrics, trajectories = _tables(tmp_path)
    assert {"mae_tau", "onestep_exact_qd[0]"} <= set(metrics["metric"])
    assert not {"mae_L_raw", "coefficient_error", "rollout_error"} & set(metrics["metric"])
    assert "model.x" in set(trajectories["name"]) and "model.H" not in set(trajectories["name"])


def test_known_energies_are_measured_too_and_other_metrics_kept(tmp_path, exact, free):
    extra = MetricValues("train", "rank", np.array([4.0, 3.0]), "1")
    measure(tmp_path, exact, Gauge.RAW, free, [extra])
    metrics = _tables(tmp_path)[0].set_index(["split", "metric", "member"])["value"]
    on_free = metrics["free"]
    assert set(on_free.index.get_level_values("metric")) == {
        "mae_tau", "mae_qdd", "mae_H_legendre", "mae_H_sum", "mae_L_raw", "min_eig_M",
    }  # fmt: skip
    assert on_free["mae_H_sum"].max() < 1e-9 and on_free["mae_tau"].max() < 1e-9
    assert metrics["train", "rank", 8] == 3
