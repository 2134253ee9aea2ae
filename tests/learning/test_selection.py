"""Basis selection on the over-complete library: exact with thresholding, not with the l1 penalty alone."""

from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from simulated import random_force

from repro.evaluation.coefficients import coefficient_errors
from repro.learning.objective import Objective
from repro.learning.optimisers.basis_selection import Selection, thresholded_least_squares
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import library, t1
from repro.models.lagrangian import Lagrangian

CONF = Path(__file__).parents[2] / "conf" / "optimiser"
DRAWS = [0, 1, 2, 3, 4]
GAUGE = ["xd^1 thetad^0 1", *(f"xd^0 thetad^1 {f}" for f in library._trigonometric(0.0, np))]


def _settings(name):
    stored = yaml.safe_load((CONF / f"{name}.yaml").read_text())
    return {key: value for key, value in stored.items() if key not in ("name", "kind")}


def _selected(data, model, optimiser, system, seeds=DRAWS):
    problem = TrainingProblem(model, [make_task(model, data.train, Objective())], seeds)
    start = torch.zeros(len(seeds), model.n_parameters, dtype=torch.float64)
    fitted = optimiser.fit(problem, start, silent, NoCheckpoint())
    errors = {m.name: m.values for m in coefficient_errors(model, fitted.parameters, system)}
    return fitted, errors


@pytest.mark.parametrize("noise", [{"tau_noise": 0.1}, {"qdd_noise": 0.5}], ids=["tau", "qdd"])
@pytest.mark.parametrize("name", ["sip", "sip_rod"])
def test_thresholding_finds_exactly_the_true_terms_in_noise(name, noise):
    system, model = load(name), Lagrangian(library, 2)
    data = random_force(system, seeds=DRAWS, samples=7500, episode_steps=100, **noise)
    _, errors = _selected(data, model, Selection(**_settings("thresholded_least_squares")), system)
    np.testing.assert_array_equal(errors["support_exact"], 1)
    assert errors["coefficient_error"].max() < 0.04  # noise of qdd is in the columns too, and shrinks coefficients


@pytest.mark.parametrize("method", ["thresholded", "lasso"])
def test_fixed_weights_stay_as_they_are(method, data, true_t1):
    """As those of a frozen sub-model: the terms beside them are selected from what they leave of tau."""
    model = Lagrangian(t1, 2)
    model.fixed = slice(0, 2)
    problem = TrainingProblem(model, [make_task(model, data.train, Objective())], (0, 1, 2))
    start = np.tile(true_t1, (3, 1))
    fitted = Selection(method=method, penalty=1e-6).fit(problem, start, silent, NoCheckpoint())
    np.testing.assert_array_equal(fitted.parameters[:, :2], start[:, :2])
    np.testing.assert_allclose(fitted.parameters, start, rtol=1e-9)
    assert fitted.notes["gauge_columns"] == []


@pytest.mark.parametrize("refit", [False, True])
def test_the_penalty_alone_keeps_false_terms(refit, system):
    data = random_force(system, seeds=DRAWS[:2], samples=1500, episode_steps=100, tau_noise=0.1)
    lasso = Selection(**_settings("lasso") | {"refit": refit})
    _, errors = _selected(data, Lagrangian(library, 2), lasso, system, DRAWS[:2])
    assert np.all(errors["missing_terms"] == 0)
    assert np.all(errors["false_terms"] > 0)


def test_refitting_takes_the_bias_off_the_true_terms(system):
    data = random_force(system, seeds=[0], samples=1500, episode_steps=100)
    errors = [
        _selected(data, Lagrangian(library, 2), Selection("lasso", penalty=0.01, refit=refit), system, [0])[1]
        for refit in (False, True)
    ]
    assert errors[0]["coefficient_error"] > 1e-3
    assert errors[1]["coefficient_error"] < 1e-9


def test_gauge_columns_are_dropped_and_named(system, data):
    fitted, _ = _selected(data, Lagrangian(library, 2), Selection(), system, [0, 1, 2])
    assert sorted(fitted.notes["gauge_columns"]) == sorted(GAUGE)
    names = Lagrangian(library, 2).coefficient_names
    assert all(fitted.parameters[0, names.index(name)] == 0 for name in GAUGE)


def test_a_term_stays_while_it_carries_its_share():
    """Orthonormal columns: a coefficient is the share of the signal that its term carries."""
    right = 7 * np.array([0.6, 0.8 * 0.6, 0.8 * 0.8, 0.0])
    np.testing.assert_allclose(thresholded_least_squares(np.eye(4), right, 0.1), right, atol=1e-15)
    np.testing.assert_allclose(thresholded_least_squares(np.eye(4), right, 0.5), right * [1, 0, 1, 0], atol=1e-15)
    np.testing.assert_array_equal(thresholded_least_squares(np.eye(4), right, 2.0), np.zeros(4))
