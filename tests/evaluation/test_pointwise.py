"""Errors of models whose errors are known beforehand."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.evaluation.pointwise import pointwise
from repro.evaluation.predictions import truth
from repro.mechanics.system import load
from repro.models.bases import fxf, t1, t2
from repro.models.gauge import Gauge
from repro.models.kinds.degenerate import Degenerate
from repro.models.kinds.trivial import Trivial
from repro.models.lagrangian import Lagrangian


def _metrics(model, parameters, part, system=None, reading="raw"):
    return {m.name: m.values for m in pointwise(model, parameters, part, system, "test", Gauge(reading))}


@pytest.mark.parametrize("reading", ["raw", "anchor", "canonical", "canonical_anchor"])
def test_the_exact_model_has_no_errors(exact, data, system, reading):
    metrics = _metrics(*exact, data.test, system, reading)
    for name, values in metrics.items():
        if name.startswith(("mae", "median")) or name == "gyroscopic_remainder":
            np.testing.assert_allclose(values, 0, atol=1e-13, err_msg=name)
    np.testing.assert_allclose(metrics["skill_tau"], 1, atol=1e-13)
    np.testing.assert_allclose(metrics["gravity"], 1, atol=1e-9)
    np.testing.assert_array_equal(metrics["trapped"], 0)
    np.testing.assert_allclose(metrics["min_eig_M"], _smallest_eigenvalue(data.test), rtol=1e-12)
    assert np.all(metrics["min_T"] >= 0)


def _smallest_eigenvalue(part):
    """Of [[0.8, 0.1 cos], [0.1 cos, 0.05]], from trace and determinant."""
    determinant = 0.8 * 0.05 - (0.1 * np.cos(part.q[..., 1])) ** 2
    return (0.425 - np.sqrt(0.425**2 - determinant)).min(1)


def test_errors_are_means_over_samples_and_components(exact, data):
    """m0 + m1 too large by 0.01: tau_x is off by 0.01 xdd, tau_theta not at all."""
    model, parameters = exact
    metrics = _metrics(model, parameters + torch.tensor([0.005, 0, 0, 0]), data.test)
    expected = 0.01 * np.abs(data.test.qdd[..., 0]).mean(1)
    np.testing.assert_allclose(metrics["mae_tau[0]"], expected, rtol=1e-6)
    np.testing.assert_allclose(metrics["mae_tau[1]"], 0, atol=1e-13)
    np.testing.assert_allclose(metrics["mae_tau"], expected / 2, rtol=1e-6)
    np.testing.assert_allclose(metrics["skill_tau"], 1 - expected / np.abs(data.test.tau[..., 0]).mean(1), rtol=1e-6)


def test_energy_errors_are_those_of_the_legendre_transform(exact, data, system):
    """V too large by 0.1 cos(theta)."""
    model, parameters = exact
    metrics = _metrics(model, parameters + torch.tensor([0, 0, 0, 0.1]), data.test, system)
    error = 0.1 * np.cos(data.test.q[..., 1])
    np.testing.assert_allclose(metrics["mae_H_legendre"], np.abs(error).mean(1), rtol=1e-6)
    centred = np.abs(error - error.mean(1, keepdims=True)).mean(1)
    np.testing.assert_allclose(metrics["mae_H_centred"], centred, rtol=1e-6)
    np.testing.assert_allclose(metrics["mae_L_raw"], np.abs(error).mean(1), rtol=1e-6)
    np.testing.assert_allclose(metrics["mae_V"], np.abs(error).mean(1), rtol=1e-6)
    np.testing.assert_allclose(metrics["mae_T"], 0, atol=1e-13)
    np.testing.assert_allclose(metrics["mae_p"], 0, atol=1e-13)
    np.testing.assert_allclose(metrics["gravity"], 1.08 / 0.98, rtol=1e-6)


GAUGES = {
    "a constant": {"potential": lambda q: 3.7},
    "dF/dt, F = sin(theta)": {"kinetic": lambda q, qd: _cos(q[1]) * qd[1]},
    "f(theta) between T and V": {
        "kinetic": lambda q, qd: 0.7 * _cos(q[1]) - _cos(2 * q[1]),
        "potential": lambda q: 0.7 * _cos(q[1]) - _cos(2 * q[1]),
    },
}
INVARIANT = (
    "gravity",
    "trapped",
    "mae_tau",
    "mae_qdd",
    "mae_H_centred",
    "mae_L_canonical",
    "min_eig_M",
    "gyroscopic_remainder",
)
CHANGES = {
    "a constant": ("mae_L_raw", "mae_H_legendre", "mae_V"),
    "dF/dt, F = sin(theta)": ("mae_L_raw", "mae_p", "mae_T"),
    "f(theta) between T and V": ("mae_T", "mae_V", "mae_H_sum", "min_T"),
}


def _cos(x):
    import casadi

    return casadi.cos(x)


@pytest.mark.parametrize("gauge", GAUGES)
def test_a_gauge_changes_no_error_that_should_not_know_of_it(gauge, written, no_weights, data, system):
    before = _metrics(written(), no_weights, data.test, system)
    after = _metrics(written(**GAUGES[gauge]), no_weights, data.test, system)
    for name in INVARIANT:
        np.testing.assert_allclose(after[name], before[name], rtol=1e-9, atol=1e-12, err_msg=name)
    assert np.all(before["mae_L_canonical"] > 0.01)
    for name in CHANGES[gauge]:
        assert np.all(np.abs(after[name] - before[name]) > 1e-3), name


def test_a_singular_mass_matrix_is_an_infinite_error(exact, data, system):
    model, _ = exact
    singular = torch.tensor([[0.4, 0.0, 0.0, 0.98], [0.4, 0.025, 0.1, 0.98]], dtype=torch.float64)
    metrics = _metrics(model, singular, data.test, system)
    for name in ("mae_qdd", "mae_qdd[0]", "mae_qdd[1]", "median_ae_qdd"):
        assert metrics[name][0] == np.inf
        assert metrics[name][1] < 1e-12
    assert metrics["skill_qdd"][0] == -np.inf
    assert metrics["min_eig_M"][0] == 0
    assert np.isfinite(metrics["mae_tau"]).all()


def test_the_trivial_model_scores_what_there_is_to_explain(data, system, no_weights):
    metrics = _metrics(Trivial(2), no_weights, data.test, system)
    np.testing.assert_allclose(metrics["mae_tau"], np.abs(data.test.tau).mean((1, 2)))
    np.testing.assert_allclose(metrics["mae_qdd"], np.abs(data.test.qdd).mean((1, 2)))
    np.testing.assert_array_equal(metrics["skill_tau"], 0)


@pytest.mark.parametrize("reading", ["physical", "printed"])
def test_the_degenerate_model_has_the_force_on_the_cart_right_and_no_acceleration(reading, data, no_weights):
    """p_x belongs to a cyclic coordinate: d/dt p_x = f exactly."""
    system = load("sip", reading)
    part = random_force(system, seeds=[0, 1], samples=600, episode_steps=100).test
    metrics = _metrics(Degenerate(system), no_weights, part, system)
    np.testing.assert_allclose(metrics["mae_tau[0]"], 0, atol=1e-12)
    assert np.all(metrics["mae_tau[1]"] > 0.05)
    assert np.all(metrics["skill_tau"] > 0.5)
    assert "mae_qdd" not in metrics


@pytest.fixture(scope="module")
def double_pendulum():
    system = load("dip")
    options = {"episode_steps": 50, "reset": "random", "force_limit": 4.0}
    return system, random_force(system, seeds=[0, 1], samples=2000, **options).test


def test_the_degenerate_model_of_the_double_pendulum_is_told_as_trapped(double_pendulum, no_weights):
    """It beats the paper's MAE_tau of 0.10, and has no gravity."""
    system, part = double_pendulum
    metrics = _metrics(Degenerate(system), no_weights, part, system)
    assert np.all(metrics["mae_tau"] < 0.10)
    np.testing.assert_array_equal(metrics["trapped"], 1)
    for name in ("gravity", "gravity[1]", "gravity[2]"):
        np.testing.assert_allclose(metrics[name], 0, atol=1e-12)


@pytest.mark.parametrize("episode_steps", [100, 1000])
def test_the_degenerate_model_is_trapped_whatever_the_spread_of_the_energy(episode_steps, system, no_weights):
    part = random_force(system, seeds=[0, 1], samples=10_000, episode_steps=episode_steps, force_limit=5.0).test
    for model in (Degenerate(system), Trivial(system.n_q)):
        np.testing.assert_array_equal(_metrics(model, no_weights, part, system)["trapped"], 1)


def test_the_true_double_pendulum_is_not_trapped(double_pendulum):
    system, part = double_pendulum
    model = Lagrangian(fxf, 3)
    true = truth(system, part.q, part.qd, part.qdd, part.tau)
    features = ((model.kinetic_features, true.kinetic), (model.potential_features, true.potential))
    solved = [
        np.linalg.lstsq(map_.jets(part.q, part.qd, part.qdd)[0, :, 0], e[0], rcond=1e-12)[0] for map_, e in features
    ]
    weights = torch.from_numpy(np.tile(np.concatenate(solved), (2, 1)))
    metrics = _metrics(model, weights, part, system)
    assert np.all(metrics["mae_tau"] < 1e-9)
    np.testing.assert_array_equal(metrics["trapped"], 0)
    weights[:, -1] *= 0.9  # gravity of the last link
    metrics = _metrics(model, weights, part, system)
    np.testing.assert_allclose(metrics["gravity[1]"], 1, atol=1e-9)
    np.testing.assert_allclose(metrics["gravity[2]"], 0.9, atol=1e-9)
    np.testing.assert_allclose(metrics["gravity"], 0.95, atol=1e-9)


def test_a_lost_inertia_is_told_as_trapped_even_where_the_energy_is_right(exact, data, system):
    model, weights = exact
    slow = replace(data.test, qd=data.test.qd / 100)
    weights[1, 1] = 0.00625  # from 0.025: M is singular upright
    metrics = _metrics(model, weights, slow, system)
    assert np.all(metrics["mae_H_centred"] < 0.1)
    np.testing.assert_array_equal(metrics["trapped"], [0, 1])


def test_without_the_true_system_only_equations_are_judged(exact, data):
    names = set(_metrics(*exact, data.test))
    assert {"mae_tau", "mae_qdd", "min_eig_M"} <= names
    assert not any("_L_" in name or "_H_" in name or name == "mae_p" for name in names)


def test_the_momentum_transform_is_compared_with_the_model_and_with_the_truth(data, system):
    model = Lagrangian(t2, 2, hidden=(4,), momentum_hidden=(2,))
    parameters = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(2)]))
    metrics = _metrics(model, parameters, data.test, system)
    parameters[:, model.transform_slice] = 0  # p_tran = 0 then
    silent = _metrics(model, parameters, data.test, system)
    mass = np.array([[0.8, 0.1], [0.1, 0.05]])
    couplings = np.stack([np.ones_like(data.test.q[..., 1]), np.cos(data.test.q[..., 1])])
    x, theta = data.test.qd[..., 0], data.test.qd[..., 1]
    p = np.stack([mass[0, 0] * x + mass[0, 1] * couplings[1] * theta, mass[0, 1] * couplings[1] * x + 0.05 * theta], -1)
    np.testing.assert_allclose(silent["mae_p_transformed"], np.abs(p).mean((1, 2)), rtol=1e-12)
    assert np.all(metrics["momentum_transform"] != silent["momentum_transform"])
    assert "momentum_transform" not in _metrics(Lagrangian(t1, 2), torch.ones(2, 4).double(), data.test, system)


def test_component_units_are_those_of_the_coordinates(exact, data):
    units = {m.name: m.unit for m in pointwise(*exact, data.test, None, "test", Gauge.RAW)}
    assert units["mae_tau[0]"] == "N" and units["mae_tau[1]"] == "N m"
    assert units["mae_qdd[0]"] == "m/s^2" and units["mae_qdd[1]"] == "rad/s^2"
