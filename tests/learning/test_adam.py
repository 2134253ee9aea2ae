"""Adam against a hand-written reference of the legacy Keras optimiser."""

import math
from itertools import pairwise

import numpy as np
import pytest
import torch
from tensors import assert_close

from repro.learning.objective import Objective
from repro.learning.optimisers import adam
from repro.learning.optimisers.adam import Adam
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian

ENGINES = ("auto", "torch")
every_engine = pytest.mark.parametrize("engine", ENGINES)


def _columns(data):
    """tau = A w for T1 and V1, differentiated by hand: (sample, component, coefficient) of the first member."""
    part = data.train
    theta, thetad = part.q[0, :, 1], part.qd[0, :, 1]
    xdd, thetadd = part.qdd[0].T
    none = np.zeros_like(theta)
    x_row = [2 * xdd, none, thetadd * np.cos(theta) - thetad**2 * np.sin(theta), none]
    theta_row = [none, 2 * thetadd, xdd * np.cos(theta), -np.sin(theta)]
    return np.stack([np.stack(x_row, axis=-1), np.stack(theta_row, axis=-1)], axis=1)


@every_engine
def test_steps_are_those_of_legacy_keras(engine, data, t1_problem, start, monkeypatch):
    """Rate lr / (1 + decay k), epsilon outside the corrected root, mean gradient of a short last batch."""
    monkeypatch.setattr(adam, "shuffled", lambda seed, samples, epoch: np.arange(samples))
    settings = {"learning_rate": 0.05, "decay": 0.3, "epsilon": 0.02, "batch_size": 60}
    columns, tau = _columns(data), data.train.tau[0]
    assert len(tau) % 60
    parameters = start(t1_problem.model)
    w, m, v = parameters[0].numpy().copy(), np.zeros(4), np.zeros(4)
    k, losses = 0, []
    for _ in range(3):
        total = 0.0
        for first in range(0, len(tau), 60):
            a, b = columns[first : first + 60], tau[first : first + 60]
            residual = np.einsum("sci,i->sc", a, w) - b
            total += (residual**2).sum() / len(tau)
            gradient = 2 * np.einsum("sc,sci->i", residual, a) / len(b)
            m = 0.9 * m + 0.1 * gradient
            v = 0.999 * v + 0.001 * gradient**2
            rate = 0.05 / (1 + 0.3 * k) * math.sqrt(1 - 0.999 ** (k + 1)) / (1 - 0.9 ** (k + 1))
            w = w - rate * m / (np.sqrt(v) + 0.02)
            k += 1
        losses.append(total)
    fitted = Adam(epochs=3, engine=engine, **settings).fit(t1_problem, parameters, silent, NoCheckpoint())
    np.testing.assert_allclose(fitted.parameters[0].numpy(), w, rtol=1e-12)
    np.testing.assert_allclose([values[0] for _, _, values in fitted.curves], losses, rtol=1e-12)


@every_engine
def test_plain_gradient_descent_has_no_moments(engine, data, t1_problem, start, monkeypatch):
    """w - rate times the mean gradient of each batch, at the rates of Keras; epsilon is in no use."""
    monkeypatch.setattr(adam, "shuffled", lambda seed, samples, epoch: np.arange(samples))
    columns, tau = _columns(data), data.train.tau[0]
    parameters = start(t1_problem.model)
    w, k = parameters[0].numpy().copy(), 0
    for _ in range(3):
        for first in range(0, len(tau), 60):
            a, b = columns[first : first + 60], tau[first : first + 60]
            w = w - 1e-3 / (1 + 0.3 * k) * 2 * np.einsum("sc,sci->i", np.einsum("sci,i->sc", a, w) - b, a) / len(b)
            k += 1
    settings = {"rule": "sgd", "learning_rate": 1e-3, "decay": 0.3, "epsilon": 7.0, "batch_size": 60}
    fitted = Adam(epochs=3, engine=engine, **settings).fit(t1_problem, parameters, silent, NoCheckpoint())
    np.testing.assert_allclose(fitted.parameters[0].numpy(), w, rtol=1e-12)


def test_the_cosine_goes_from_the_rate_to_a_ten_thousandth_of_it():
    schedule = Adam(schedule="cosine", learning_rate=0.2, decay=0.7)
    assert schedule.rate(0, 1000) == pytest.approx(0.2, rel=1e-15)
    assert schedule.rate(500, 1000) == pytest.approx(0.2 * (1 + 1e-4) / 2, rel=1e-12)
    assert schedule.rate(1000, 1000) == pytest.approx(0.2e-4, rel=1e-12)
    rates = [schedule.rate(step, 1000) for step in range(1001)]
    assert all(later < earlier for earlier, later in pairwise(rates))


def test_the_keras_rate_decays_harmonically():
    schedule = Adam(learning_rate=0.1, decay=1e-6)
    assert schedule.rate(0, 5) == 0.1
    assert schedule.rate(1_000_000, 5) == pytest.approx(0.05, rel=1e-12)


def test_batches_are_fresh_permutations_of_each_seed_and_epoch():
    orders = [adam.shuffled(seed, 50, epoch) for seed in (0, 1) for epoch in (0, 1)]
    assert all(sorted(order) == list(range(50)) for order in orders)
    assert len({tuple(order) for order in orders}) == 4
    np.testing.assert_array_equal(adam.shuffled(1, 50, 1), orders[3])


@pytest.mark.parametrize("samples", [1, 2, 3, 64, 65, 1000])
def test_the_order_is_that_of_numpys_generator(samples):
    for epoch in range(20):
        expected = np.random.default_rng([3, 11, epoch]).permutation(samples)
        np.testing.assert_array_equal(adam.shuffled(3, samples, epoch), expected)


@every_engine
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_resumed_fit_ends_at_the_same_bits(engine, precision, t1_problem, start, memory):
    optimiser = Adam(epochs=6, batch_size=50, engine=engine, precision=precision, schedule="cosine")
    parameters = start(t1_problem.model)
    whole = optimiser.fit(t1_problem, parameters, silent, NoCheckpoint())
    checkpoint = memory(stop_at=3)
    with pytest.raises(KeyboardInterrupt):
        optimiser.fit(t1_problem, parameters, silent, checkpoint)
    resumed = optimiser.fit(t1_problem, parameters, silent, checkpoint)
    assert torch.equal(resumed.parameters, whole.parameters)
    assert [step for step, _, _ in resumed.curves] == [1, 2, 3, 4, 5, 6]
    for (_, _, ours), (_, _, expected) in zip(resumed.curves, whole.curves, strict=True):
        np.testing.assert_array_equal(ours, expected)


@every_engine
def test_a_member_that_diverges_is_marked_and_changes_no_bit_of_the_others(engine, data, spoilt, make_problem, start):
    model = Lagrangian(t2, 2, hidden=(4,))
    parameters = start(model)
    optimiser = Adam(epochs=4, batch_size=50, engine=engine)
    healthy, sick = (
        optimiser.fit(make_problem(model, each), parameters, silent, NoCheckpoint()) for each in (data, spoilt)
    )
    assert healthy.status == ["ok"] * 3
    assert sick.status == ["ok", "diverged at epoch 1", "ok"]
    assert torch.equal(sick.parameters[[0, 2]], healthy.parameters[[0, 2]])
    assert torch.equal(sick.parameters[1], parameters[1])


@every_engine
def test_a_member_that_diverges_later_keeps_its_last_finite_weights(engine, t1_problem, start):
    """The first step of Adam has the size of the rate; the loss there overflows."""
    optimiser = Adam(epochs=5, batch_size=200, learning_rate=1e200, engine=engine)
    fitted = optimiser.fit(t1_problem, start(t1_problem.model), silent, NoCheckpoint())
    assert fitted.status == ["diverged at epoch 2"] * 3
    assert_close(fitted.parameters.abs(), torch.full((3, 4), 1e200, dtype=torch.float64), rtol=1e-3, atol=0)


def test_l1_pulls_coefficients_that_the_data_do_not_hold(data, free, start):
    model = Lagrangian(t2, 2, hidden=(4,))
    weights = torch.zeros(model.n_parameters, dtype=torch.float64)
    weights[model.potential_slice] = 5.0
    task = make_task(model, data.train, Objective())
    parameters = start(model)
    sizes = [
        Adam(epochs=150, batch_size=200)
        .fit(TrainingProblem(model, [task], [0, 1, 2], l1), parameters, silent, NoCheckpoint())
        .parameters[:, model.potential_slice]
        .abs()
        .max()
        for l1 in (None, weights)
    ]
    assert sizes[1] < 0.05 < sizes[0]


def test_float32_comes_close_to_float64(t1_problem, start):
    parameters = start(t1_problem.model)
    double, single = (
        Adam(epochs=5, batch_size=50, precision=precision)
        .fit(t1_problem, parameters, silent, NoCheckpoint())
        .parameters
        for precision in ("float64", "float32")
    )
    assert single.dtype == torch.float32
    assert_close(single.double(), double, rtol=1e-4, atol=1e-4)
