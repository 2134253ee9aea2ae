"""Which data in which order: the phases that a sequence and a curriculum make, and what they achieve."""

import numpy as np
import pandas as pd
import pytest
import torch
from simulated import random_force

from repro.evaluation.predictions import predict
from repro.learning.optimisers import adam, least_squares, levenberg_marquardt
from repro.learning.phases import TrainingData, phases_of
from repro.learning.result import Fitted, NoCheckpoint
from repro.learning.training_options import Training
from repro.library.ensemble import build_model, fit_ensemble
from repro.models.bases import t1, t2
from repro.models.kinds import structured
from repro.models.kinds.trivial import Trivial
from repro.models.lagrangian import Lagrangian
from repro.pipeline.stages.fit import keep
from repro.pipeline.stages.stored_fit import CURVES, load_parameters

MODEL = Lagrangian(t2, 2, hidden=(4,))
SHORT = levenberg_marquardt.Options(restarts=1, iterations=20, samples=None)


def _fit(recipe, data, free, system, optimiser=SHORT, model=MODEL):
    texts = []
    training = Training(*recipe, optimiser)
    given = TrainingData(data, free, system, [3, 8])
    fitted, seconds = fit_ensemble(model, training, given, lambda fraction, text: texts.append(text), NoCheckpoint())
    assert seconds >= 0
    return fitted, list(dict.fromkeys(text.split(":")[0] for text in texts))


def _energy_error(parameters, dataset, form):
    said = predict(MODEL, parameters, dataset.q, dataset.qd, dataset.qdd, dataset.tau)
    energy = said.hamiltonian(dataset.qd) if form == "legendre" else said.kinetic + said.potential
    return np.abs(energy - dataset.energy).mean(1)


def test_each_member_starts_from_its_own_seed(recipe, data, system):
    fitted, _ = _fit(recipe(), [data], None, system, adam.Options(epochs=1, learning_rate=1e-12, epsilon=1.0))
    start = MODEL.initial([np.random.default_rng([seed, 1]) for seed in (3, 8)])
    np.testing.assert_allclose(fitted.parameters.numpy(), start, atol=1e-9)


def test_pretraining_on_known_energies_comes_first(recipe, data, free, system):
    fitted, names = _fit(recipe("pretrain"), [data], free, system)
    assert names == ["D_H", "D"]
    alone, _ = _fit(recipe(), [data], None, system)
    assert not torch.equal(fitted.parameters, alone.parameters)
    assert fitted.notes == {"epochs": 20}


@pytest.mark.parametrize("form", ["legendre", "sum"])
@pytest.mark.parametrize("kind", ["pretrain_only", "joint"])
def test_known_energies_are_learned_where_they_are_asked_for(kind, form, recipe, data, free, system):
    optimiser = levenberg_marquardt.Options(restarts=1, iterations=60, samples=None)
    asked, names = _fit(recipe(kind, energy_form=form, energy_weight=100.0), [data], free, system, optimiser)
    assert not {"D_H", "D"} & set(names)  # one phase needs no name
    alone, _ = _fit(recipe(), [data], None, system, optimiser)
    assert np.all(_energy_error(asked.parameters, free.train, form) < 0.1)
    assert np.all(_energy_error(alone.parameters, free.train, form) > 0.2)


@pytest.mark.parametrize("convention", ["physical", "printed"])
def test_an_anchor_fixes_the_energy_of_the_upright_rest(convention, recipe):
    from repro.mechanics.system import load

    system = load("sip", convention)
    data = random_force(system, seeds=[3, 8], samples=300, episode_steps=100)
    optimiser = levenberg_marquardt.Options(restarts=1, iterations=40, samples=None)
    anchored, _ = _fit(recipe("anchored", energy_weight=10.0), [data], None, system, optimiser)
    free, _ = _fit(recipe(), [data], None, system, optimiser)
    q = np.broadcast_to(system.at_rest("upright"), (2, 1, 2)).copy()
    zero = np.zeros_like(q)
    energies = []
    for fitted in (anchored, free):
        said = predict(MODEL, fitted.parameters, q, zero, zero, zero)
        energies.append(said.hamiltonian(zero)[:, 0])
    np.testing.assert_allclose(energies[0], 0.98, atol=0.01)
    assert np.all(np.abs(energies[1] - 0.98) > 0.02)


def test_a_curriculum_goes_through_its_stages(recipe, data, free, system):
    earlier = random_force(system, seeds=[3, 8], samples=100, episode_steps=20)
    fitted, names = _fit(recipe("pretrain"), [earlier, data], free, system)
    assert names == ["D_H", "D, stage 1", "D"]
    direct, _ = _fit(recipe("pretrain"), [data], free, system)
    assert not torch.equal(fitted.parameters, direct.parameters)


def test_a_fit_may_end_with_equal_weights(recipe, data, free, system):
    """The last phase has every task of the one before, takes its share of the iterations, and lowers its own loss."""
    weighted, _ = _fit(recipe("joint", error_scale=5.0), [data], free, system)
    finished, names = _fit(recipe("joint", error_scale=5.0, equal_weight_share=0.25), [data], free, system)
    assert names == ["D and D_H", "equal weights"]
    assert finished.notes == {"epochs": 25}
    recipe_of_both = recipe("joint", error_scale=5.0, equal_weight_share=0.25)
    (_, last) = phases_of(MODEL, *recipe_of_both, TrainingData([data], free, system, [3, 8]))
    assert len(last.problem.tasks) == 2
    losses = [last.problem.loss(fitted.parameters) for fitted in (weighted, finished)]
    assert torch.all(losses[1] < losses[0])


def test_only_training_samples_are_used(recipe, data, system):
    """The test part may be anything."""
    from dataclasses import replace

    tau = data.tau.copy()
    tau[:, data.n_train :] = np.nan
    fits = [_fit(recipe(), [each], None, system)[0].parameters for each in (data, replace(data, tau=tau))]
    assert torch.equal(*fits)


def test_the_l1_weights_of_an_objective_fall_on_their_own_coefficients(recipe, data, system):
    model, optimiser = Lagrangian(t1, 2), adam.Options(epochs=600, learning_rate=0.02)
    plain, shrunk = (
        _fit(recipe(l1_potential=weight), [data], None, system, optimiser, model)[0].parameters for weight in (0, 50)
    )
    assert torch.all(shrunk[:, 3].abs() < 0.05) and torch.all(plain[:, 3].abs() > 0.3)
    assert torch.all(shrunk[:, 0] > 0.3)


def test_d_h_is_asked_for_where_it_is_needed(recipe, data, system):
    with pytest.raises(ValueError, match="needs D_H"):
        _fit(recipe("joint"), [data], None, system)


def test_a_model_without_weights_is_not_fitted(recipe, data, system):
    fitted, _ = _fit(recipe(), [data], None, system, SHORT, Trivial(2))
    assert fitted.parameters.shape == (2, 0) and fitted.status == ["ok", "ok"] and fitted.curves == []


def test_the_velocity_scale_is_that_of_the_first_phase(data, system):
    short = random_force(system, seeds=[3, 8], samples=100, episode_steps=10)
    model = build_model(structured.Options(hidden=(4,)), "t2", [short, data], system)
    np.testing.assert_allclose(model.velocity_scale, short.train.qd.reshape(-1, 2).std(0))
    assert np.all(model.velocity_scale < data.qd.reshape(-1, 2).std(0))


def test_weights_and_curves_are_kept(tmp_path, recipe, data, system):
    fitted, _ = _fit(recipe(), [data], None, system)
    summary = keep(tmp_path, fitted, [3, 8], 12.5)
    assert summary == {"status": ["ok", "ok"], "seconds": 12.5, "notes": {"epochs": 20}}
    np.testing.assert_array_equal(load_parameters(tmp_path), fitted.parameters)
    table = pd.read_parquet(tmp_path / CURVES)
    assert set(table["member"]) == {3, 8} and set(table["name"]) == {"loss", "min_eig_M"}
    last = table[(table["member"] == 8)].sort_values("step")["value"].iloc[-1]
    assert last == fitted.curves[-1][2][1]


def test_a_fit_without_curves_leaves_an_empty_table_of_the_same_types(tmp_path):
    keep(tmp_path, Fitted(torch.zeros(1, 2), [], ["ok"]), [0], 0.0)
    table = pd.read_parquet(tmp_path / CURVES)
    assert len(table) == 0 and str(table["value"].dtype) == "float64" and str(table["member"].dtype) == "int64"


def test_least_squares_through_the_stage_is_exact(recipe, data, free, system):
    fitted, _ = _fit(recipe("joint"), [data], free, system, least_squares.Options(), Lagrangian(t1, 2))
    np.testing.assert_allclose(fitted.parameters, [[0.4, 0.025, 0.1, 0.98]] * 2, atol=1e-9)


@pytest.mark.parametrize(("kind", "expected"), [("pretrain", 3 + 4), ("pretrain_only", 3)])
def test_the_pretraining_may_have_its_own_epochs(kind, expected, recipe, data, free, system):
    fitted, _ = _fit(recipe(kind, pretraining_epochs=3), [data], free, system, adam.Options(epochs=4))
    assert fitted.curves[-1][0] == expected


def test_epochs_do_not_concern_those_who_do_not_count_in_them(recipe, data, free, system):
    with_epochs, without = (
        _fit(recipe("pretrain", pretraining_epochs=epochs), [data], free, system)[0].parameters for epochs in (3, None)
    )
    assert torch.equal(with_epochs, without)


def test_in_closed_form_a_later_phase_keeps_what_it_does_not_see(recipe, data, free, system):
    """D says nothing of a constant in T or of the split of cos(theta); D_H fixes both, and D leaves them alone."""
    from repro.models.bases import fxf_gauge

    model = Lagrangian(fxf_gauge, 2)
    for kind, largest in {"pretrain": (0, 1e-6), "main": (0.3, 2)}.items():
        fitted, _ = _fit(recipe(kind, energy_form="sum"), [data], free, system, least_squares.Options(), model)
        said = predict(model, fitted.parameters, free.q, free.qd, free.qdd, free.tau)
        error = np.abs(said.kinetic + said.potential - free.energy).mean(1)
        assert np.all((largest[0] <= error) & (error < largest[1]))
