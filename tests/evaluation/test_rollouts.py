"""Predictions over time: those of the true model are the data, those of others have the errors of their integrator."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.evaluation import model_motion
from repro.evaluation.rollouts import (
    POINTS,
    can_simulate,
    first_points,
    one_step_errors,
    rollout_errors,
    window_error,
)
from repro.evaluation.uncertainty import motion_errors
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.models.bases import t1, t2
from repro.models.kinds import blackbox
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.trivial import Trivial
from repro.models.lagrangian import Lagrangian
from repro.models.model import acceleration


def _values(metrics):
    return {m.name: m.values for m in metrics}


def test_the_true_model_rolls_out_as_the_data(exact, data):
    rollout = first_points(*exact, data.test)
    assert rollout.model.shape == (2, 120, 4)
    np.testing.assert_allclose(rollout.model, rollout.plant, atol=1e-9)
    errors = _values(rollout_errors(rollout, data.test))
    assert max(errors["rollout_qd[0]"].max(), errors["rollout_qd[1]"].max()) < 1e-10


def test_the_true_model_has_no_error_over_steps_and_windows(exact, data):
    for values in _values(one_step_errors(*exact, data.test)).values():
        np.testing.assert_allclose(values, 0, atol=1e-13)
    assert _values(window_error(*exact, data.test))["rollout_error"].max() < 1e-12


def test_a_rollout_starts_anew_with_every_episode(exact, data):
    """The test part begins within an episode of the 480th sample; a new one starts at 500."""
    model, parameters = exact
    wrong = parameters * torch.tensor([1.0, 1.0, 1.0, 1.3])
    rollout = first_points(model, wrong, data.test)
    starts = np.flatnonzero(np.diff(data.test.episode, prepend=-1))
    assert starts.tolist() == [0, 20]
    np.testing.assert_array_equal(rollout.model[:, starts], rollout.plant[:, starts])
    error = np.abs(rollout.model - rollout.plant).max((0, 2))
    assert error[19] > 1e-2 and error[90] > 1e-2 and error[21] < 1e-2


def test_errors_of_the_weights_carry_over_to_the_rollout(exact, data):
    """As finite differences of whole rollouts say."""
    model, parameters = exact
    draw, size = np.random.default_rng(2), model.n_parameters
    factor = np.stack([np.eye(size) + 0.3 * draw.normal(size=(size, size)) for _ in parameters])
    covariance = factor @ factor.swapaxes(1, 2)
    rollout = first_points(model, parameters, data.test)
    found = motion_errors(model, parameters.numpy(), np.linalg.inv(covariance), rollout.model, data.test)
    h = 1e-5
    slopes = []
    for step in np.moveaxis(factor, 2, 0):
        ahead, behind = (
            first_points(model, parameters + sign * h * torch.from_numpy(step), data.test).model for sign in (1, -1)
        )
        slopes.append((ahead - behind) / (2 * h))
    expected = np.sqrt(np.square(slopes).sum(0))
    np.testing.assert_allclose(found[:, :60], expected[:, :60], rtol=2e-3, atol=1e-6)


def test_no_more_points_than_fig_4_shows(exact, system):
    part = random_force(system, seeds=[0, 1], samples=2000, episode_steps=100).test
    assert first_points(*exact, part).time[-1] == pytest.approx((POINTS - 1) * 0.04)


def _single_steps(system, time_step):
    """Episodes of two samples from the same 100 states under the same forces."""
    random = np.random.default_rng(0)
    initial = random.uniform([-1, -3, -1, -4], [1, 3, 1, 4], (100, 4))
    force = np.repeat(random.uniform(-5, 5, (100, 1, 1)), 2, axis=1) * [1.0, 0.0]
    states = simulate(dynamics_of(system).acceleration, initial, force[:, :1], time_step, angles=system.angles)
    q, qd, tau = (array.reshape(1, 200, 2) for array in (states[..., :2], states[..., 2:], force))
    return Dataset(
        q=q, qd=qd, qdd=evaluate(dynamics_of(system).acceleration, q, qd, tau), tau=tau, time=np.arange(200.0),
        episode=np.arange(200) // 2, n_train=0, coordinates=system.coordinates, time_step=time_step,
    )  # fmt: skip


def test_an_euler_step_of_the_true_model_is_of_first_order(exact, system):
    """Local error h^2 a step, that is order one: half the step, a quarter of the error."""
    model, parameters = exact
    errors = []
    for step in (0.01, 0.005):
        part = _single_steps(system, step)
        rollout = first_points(model, parameters[:1], part)
        errors.append(_values(rollout_errors(rollout, part)))
    for component in ("[0]", "[1]"):
        ratio = errors[0][f"onestep_euler_qd{component}"] / errors[1][f"onestep_euler_qd{component}"]
        assert ratio == pytest.approx(4.0, rel=0.05)


def test_an_euler_step_takes_the_models_acceleration_at_its_start(exact, system):
    part = _single_steps(system, 0.01)
    model, parameters = exact
    heavier = parameters[:1] * torch.tensor([2.0, 2.0, 2.0, 0.0])  # and without gravity
    rollout = first_points(model, heavier, part)
    theta, thetad = part.q[0, ::2, 1], part.qd[0, ::2, 1]
    mass = 2 * np.array([[0.8 + 0 * theta, 0.1 * np.cos(theta)], [0.1 * np.cos(theta), 0.05 + 0 * theta]])
    force = np.stack([part.tau[0, ::2, 0] + 0.2 * thetad**2 * np.sin(theta), 0 * theta], axis=-1)
    qdd = np.linalg.solve(mass.transpose(2, 0, 1), force[..., None])[..., 0]
    np.testing.assert_allclose(rollout.one_step_euler[0, 1::2, 2:], part.qd[0, ::2] + 0.01 * qdd, atol=1e-12)
    np.testing.assert_allclose(rollout.one_step_euler[0, 1::2, :2], part.q[0, ::2] + 0.01 * part.qd[0, ::2], atol=1e-12)


def test_an_exact_step_uses_each_members_own_weights(exact, data):
    model, parameters = exact
    mixed = parameters.clone()
    mixed[1, 3] = 0.5
    errors = _values(one_step_errors(model, mixed, data.test))["onestep_exact_qd[1]"]
    assert errors[0] < 1e-13
    assert errors[1] > 1e-3


def test_a_window_error_grows_with_the_error_of_the_model_and_is_at_most_one(exact, data):
    model, parameters = exact
    errors = [
        _values(window_error(model, parameters * scale, data.test))["rollout_error"]
        for scale in (torch.tensor([1.0, 1.0, 1.0, factor]) for factor in (1.001, 1.1, -20.0))
    ]
    assert np.all(errors[0] < errors[1]) and np.all(errors[1] < errors[2]) and np.all(errors[2] <= 1)


def test_a_window_error_is_a_geometric_mean_of_relative_distances(exact, system, monkeypatch):
    """At rest upright z = (0, 1, 0, 0, 0): a model whose cart moves at a is a away from it, and (1 + a^2)^.5 long."""
    still, at = np.zeros((2, 101, 2)), np.arange(101)
    part = Dataset(
        q=still, qd=still, qdd=still, tau=still, time=at * 0.04, episode=0 * at, n_train=0,
        coordinates=system.coordinates, time_step=0.04,
    )  # fmt: skip
    speeds = np.linspace(0.1, 2.0, 50)

    def moving(acceleration, initial, tau, time_step, parameters, angles, engine):
        states = np.zeros((len(initial), 51, 4))
        states[:, 1:, 2] = speeds
        return states

    monkeypatch.setattr(model_motion, "simulate", moving)
    expected = np.exp(np.log(speeds / (1 + np.sqrt(1 + speeds**2))).mean())
    np.testing.assert_allclose(_values(window_error(*exact, part))["rollout_error"], expected, rtol=1e-12)


def test_a_model_that_blows_up_has_infinite_errors_and_the_largest_window_error(exact, data):
    model, parameters = exact
    broken = parameters.clone()
    broken[1] = torch.tensor([0.4, -1e-12, 0.0, 0.98])  # no inertia of the pole: it is thrown away at once
    rollout = _values(rollout_errors(first_points(model, broken, data.test), data.test))
    assert np.isinf(rollout["rollout_qd[1]"][1]) and rollout["rollout_qd[1]"][0] < 1e-10
    assert _values(window_error(model, broken, data.test))["rollout_error"][1] > 0.5


def test_short_data_have_no_windows_and_no_steps(exact, data):
    short = replace(data, **{name: getattr(data, name)[:, :30] for name in ("q", "qd", "qdd", "tau")},
                    time=data.time[:30], episode=data.episode[:30], n_train=0)  # fmt: skip
    assert list(window_error(*exact, short)) == []
    apart = replace(short, episode=np.arange(30))
    assert list(one_step_errors(*exact, apart)) == []
    np.testing.assert_array_equal(first_points(*exact, apart).model, first_points(*exact, apart).plant)


def test_models_without_weights_and_very_large_ones_are_not_simulated():
    assert can_simulate(Lagrangian(t1, 2))
    assert not can_simulate(Trivial(2))
    assert not can_simulate(Lagrangian(t2, 2, hidden=(500, 500)))


def test_the_acceleration_of_a_black_box_is_its_own(data):
    model = BlackBox(2, blackbox.Options(hidden=(3,)))
    weights = model.initial([np.random.default_rng(0)])
    part = data.test
    prepared = {name: torch.from_numpy(a) for name, a in model.prepare(part.q, part.qd, part.qdd, part.tau).items()}
    expected = model.evaluate(torch.from_numpy(np.repeat(weights, 2, axis=0)), prepared).acceleration
    ours = evaluate(acceleration(model), part.q, part.qd, part.tau, weights[0])
    np.testing.assert_allclose(ours, expected.numpy(), rtol=1e-10)
