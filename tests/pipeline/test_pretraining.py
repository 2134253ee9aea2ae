"""The fit of D_H alone is a stage of its own: fits that begin with it share it, and end where they would without it."""

import numpy as np
import pytest

from repro.config.compose import compose
from repro.learning.result import Fitted
from repro.library.ensemble import fit_ensemble
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.pipeline.stages import fit
from repro.pipeline.stages.stored_fit import model_of
from repro.tracking.store import Store

TINY = ("scale=smoke", "data.samples=120", "data.episode_steps=40", "sequence.initial_angles=4", "record=false")
FXF = ("system=dip", "basis=fxf", "scale.epochs=1", "objective.l1_kinetic=1e-5")
T2 = ("basis=t2", "model.hidden=[3]", "scale.iterations=1", "optimiser.iterations=6", "scale.epochs=1")
CASES = {
    "coefficients, Adam": (*FXF, "optimiser.epochs=6", "sequence.pretraining_epochs=4"),
    "coefficients, all samples": ("basis=t1", "optimiser=lbfgs", "scale.iterations=1", "optimiser.iterations=25"),
    "coefficients, closed form": ("basis=t1", "optimiser=least_squares"),
    "network": (*T2, "optimiser=levenberg_marquardt", "optimiser.restarts=2", "optimiser.trial_iterations=2"),
    "watched at every step": (*T2, "optimiser=lbfgs", "objective.passivity_states=5"),
    "spread of the data": ("model=structured", "model.hidden=[2]", "optimiser=levenberg_marquardt"),
}


def pipeline(*overrides):
    composed = compose([*{each.partition("=")[0]: each for each in (*TINY, *overrides)}.values()])
    return Pipeline.of(composed.config, composed.command)


def made(made_by, store):
    """The stored fit of a pipeline's run, and what `fit_ensemble` makes of the same data in one go."""
    execute(made_by, store)
    stage = store.find(made_by.fit_stage.id, kind="fits")
    model, data = model_of(made_by.fit_options, stage.upstream), fit.training_data(made_by.fit_options, stage.upstream)
    return stage, fit_ensemble(model, made_by.fit_options.training, data)[0]


def same(one: Fitted, other: Fitted):
    np.testing.assert_array_equal(np.asarray(one.parameters, dtype=float), np.asarray(other.parameters, dtype=float))
    assert (one.status, one.notes) == (other.status, other.notes)
    for curves in (one.curves, other.curves):
        curves.sort(key=lambda point: (point[0], point[1]))  # which is stable: a phase ends where the next one begins
    for (step, name, values), (its_step, its_name, its_values) in zip(one.curves, other.curves, strict=True):
        assert (step, name) == (its_step, its_name)
        np.testing.assert_array_equal(values, its_values)


@pytest.mark.slow
@pytest.mark.parametrize("sequence", ["pretrain", "pretrain_only"])
@pytest.mark.parametrize("case", CASES)
def test_a_fit_in_two_stages_is_the_fit_in_one(case, sequence, tmp_path):
    """Weights, status and learning curves to the bit; the seconds are those of both stages."""
    stage, whole = made(pipeline(*CASES[case], f"sequence={sequence}"), Store(tmp_path))
    same(fit.stored(stage), whole)
    assert stage.summary["seconds"] >= stage.upstream["pretraining"].summary["seconds"] > 0


def test_fits_that_begin_alike_share_the_beginning(tmp_path, monkeypatch):
    """Whatever they learn afterwards: another D, other epochs, or nothing."""
    pipelines = [
        pipeline(*FXF, "optimiser.epochs=6", "sequence=pretrain_only", "data=long"),
        pipeline(
            *FXF, "sequence=pretrain", "data.tau_noise=0.1", "optimiser.epochs=9", "sequence.pretraining_epochs=6"
        ),
    ]
    first, second = (one.pretraining_stage for one in pipelines)
    assert first.id == second.id and set(first.upstream) == {"free"}
    begun, store, fitted = [], Store(tmp_path), fit.make

    def noted(folder, options, upstream):
        begun.append("pretraining" not in upstream)
        return fitted(folder, options, upstream)

    monkeypatch.setattr(fit, "make", noted)
    for one in pipelines:
        execute(one, store)
    assert begun == [True, False, False]
    alone, together = (fit.stored(store.find(one.fit_stage.id)) for one in pipelines)
    learned, followed = (
        [values for step, name, values in one.curves if name == "loss" and step <= 6] for one in (alone, together)
    )
    np.testing.assert_array_equal(learned, followed)


@pytest.mark.parametrize(
    ("change", "is_shared"),
    [
        ("data.force_limit=4", True),
        ("objective.l1_kinetic=1e-4", False),
        ("optimiser.learning_rate=0.02", False),
        ("sequence.energy_weight=2", False),
        ("sequence.initial_angles=3", False),
        ("seeds=3", False),
        ("system.m1=0.3", False),
        ("model.initialisation=ones", False),
    ],
)
def test_what_the_beginning_depends_on(change, is_shared):
    one, other = (pipeline(*FXF, "sequence=pretrain", *more) for more in ((), (change,)))
    assert (one.pretraining_stage.id == other.pretraining_stage.id) == is_shared
    assert one.fit_stage.id != other.fit_stage.id


@pytest.mark.parametrize("model", ["structured", "lagrangian basis=t2", "lagrangian basis=t1 model.damping=diagonal"])
def test_a_model_that_reads_d_begins_anew_with_another_d(model):
    """Built by the spread of D, or with too many weights to keep at every point of the curves."""
    settings = (f"model={model}".split(), ("sequence=pretrain",))
    one, other = (pipeline(*settings[0], *settings[1], *more) for more in ((), ("data.force_limit=4",)))
    assert one.pretraining_stage.id != other.pretraining_stage.id and "data" in one.pretraining_stage.upstream


@pytest.mark.parametrize("sequence", ["main", "joint", "anchored"])
def test_other_sequences_have_no_such_stage(sequence):
    assert pipeline("basis=t1", f"sequence={sequence}").pretraining_stage is None


def test_a_kill_on_the_way_loses_nothing(tmp_path, monkeypatch):
    """Killed in the beginning, and again in what follows: no epoch is fitted twice, and the result is the same."""
    one, kept, epochs = pipeline(*FXF, "optimiser.epochs=6", "sequence=pretrain"), [], []
    monkeypatch.setattr(fit, "PAUSE_SECONDS", 0.0)
    save = fit.FileCheckpoint.save

    def killed(checkpoint, state):
        save(checkpoint, state)
        epochs.append(getattr(state.inner, "epoch", None))
        kept.append(state)
        if len(kept) in (3, 11):
            raise KeyboardInterrupt

    monkeypatch.setattr(fit.FileCheckpoint, "save", killed)
    for attempt in range(3):
        try:
            execute(one, Store(tmp_path))
        except KeyboardInterrupt:
            assert attempt < 2
    assert [epoch for epoch in epochs if epoch] == [1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6]
    monkeypatch.undo()
    stage = Store(tmp_path).find(one.fit_stage.id)
    same(fit.stored(stage), made(one, Store(tmp_path / "again"))[1])
