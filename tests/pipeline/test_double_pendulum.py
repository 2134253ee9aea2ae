"""The double pendulum from its settings to its metrics: what each kind of data and each sequence achieves."""

import numpy as np
import pandas as pd
import pytest

from repro.config.compose import compose
from repro.errors import UserError
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

DIP = ("system=dip", "data.force_limit=4", "record=false", "scale=quick", "sequence.initial_angles=10")
CLOSED = (*DIP, "optimiser=least_squares", "data.samples=1250")
GAUGE = (*CLOSED, "seeds=1", "basis=fxf_gauge", "sequence.energy_form=sum")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Metrics of a run: the worst member of each (split, metric). Runs share their datasets in one store."""
    store = Store(tmp_path_factory.mktemp("outputs"))

    def run(*overrides):
        composed = compose(overrides)
        record = execute(Pipeline.of(composed.config, composed.command), store)
        table = pd.read_parquet(record.folder / "metrics.parquet")
        return record, table.groupby(["split", "metric"])["value"].max()

    return run


def test_forces_alone_give_the_whole_lagrangian(run):
    record, worst = run(*CLOSED, "seeds=2", "basis=fxf")
    for metric, bar in {"mae_tau": 1e-10, "mae_qdd": 1e-6, "mae_L_raw": 1e-8, "mae_H_sum": 1e-8}.items():
        assert worst["test", metric] < bar
    assert worst["test", "coefficient_error"] < 1e-8 and worst["test", "trapped"] == 0
    assert worst["train", "rank"] == 28
    assert (record.summary["card"]["system"], record.summary["card"]["grid"]) == ("dip", None)


def test_free_motion_gives_its_own_energies_and_no_others(run):
    record, worst = run(*CLOSED, "seeds=2", "basis=fxf", "sequence=pretrain_only")
    assert worst["free", "mae_H_sum"] < 5.3e-4 and worst["free", "mae_tau"] < 1e-6
    assert worst["test", "mae_L_raw"] > 0.5 and worst["test", "trapped"] == 1
    assert worst["train", "null_directions"] == 3
    words = pd.read_parquet(record.folder / "identifiability.parquet")["direction"]
    assert "(xd + 0.15 theta1d cos(theta1) + 0.05 theta2d cos(theta2))^2" in set(words)
    assert record.summary["card"]["grid"] == "product of 10"


@pytest.mark.parametrize(("noise", "bar"), [(0.0, 1e-5), (0.1, 0.05)])
def test_both_together_fix_the_energies_of_a_basis_with_gauge_terms(run, noise, bar):
    gauge = (*GAUGE, f"data.tau_noise={noise}")
    assert run(*gauge, "sequence=joint")[1]["test", "mae_H_sum"] < bar
    for open_ended in ("main", "anchored"):
        assert run(*gauge, f"sequence={open_ended}")[1]["test", "mae_H_sum"] > 0.3


def test_the_momentum_of_the_cart_stays_as_a_gauge_where_a_fit_starts_with_it(run):
    record, worst = run(*GAUGE, "sequence=joint", "optimiser.regularise_towards=start")
    assert worst["test", "mae_H_sum"] > 1e-3 and worst["test", "mae_H_legendre"] < 1e-7
    assert record.summary["card"]["optimiser"] == "least_squares_from_start"


@pytest.mark.parametrize(
    "overrides",
    [
        ("system=dip", "basis=t2", "optimiser=levenberg_marquardt", "optimiser.restarts=1"),
        ("system=cart_rods", "basis=t2", "optimiser=lbfgs"),
        ("system=cart_rods", "model=structured", "optimiser=levenberg_marquardt", "optimiser.restarts=1"),
        (
            "system=cart_rods",
            "basis=fxf",
            "sequence=pretrain",
            "sequence.pretraining_epochs=2",
            "sequence.initial_angles=3",
        ),
    ],
    ids=lambda overrides: " ".join(overrides[:2]),
)
def test_every_model_runs_on_more_than_one_link(run, overrides):
    _, worst = run("scale=smoke", "seeds=1", "record=false", "data.samples=200", *overrides)
    assert np.isfinite(worst["test", "mae_tau"]) and np.isfinite(worst["test", "mae_H_centred"])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            ["basis=t1"],
            "is made for coordinates in m, rad, and system=dip has m, rad, rad; use one of engineered, fxf",
        ),
        (["basis=library"], "basis.name = 'library': is made for coordinates in m, rad"),
        (["basis=fxf", "sequence.pretraining_epochs=3"], "sequence=main has no phase on D_H alone"),
        (
            ["basis=fxf", "sequence=pretrain", "sequence.pretraining_epochs=3", "optimiser=lbfgs"],
            "does not count in epochs",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(change, told):
    with pytest.raises(UserError, match="=") as refused:
        compose(["system=dip", *change])
    assert told in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.slow
def test_the_papers_sequence_with_a_decaying_rate(run):
    """The paper prints 0.10 N and 12.35 J, at a constant rate."""
    adam = (*DIP[:2], "seeds=5", "record=false", "optimiser=adam_cosine", "objective.l1_kinetic=1e-5")
    paper = ("scale=paper", "basis=fxf", "data=long", "data.samples=100000")
    record, _ = run(*adam, *paper, "sequence=pretrain", "sequence.pretraining_epochs=300", "optimiser.epochs=1000")
    assert record.summary["median"]["mae_tau"] < 0.01 and record.summary["median"]["mae_L_raw"] < 1.0
