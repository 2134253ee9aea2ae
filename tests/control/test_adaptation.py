"""Re-identification on line: exact on a linear model, guarded, and no worse for noise than its prior says."""

import numpy as np
import pytest
from cart_task import random_start
from excited_motion import DT, fitted, motion, training

from repro.codegen.array_evaluation import evaluate
from repro.control.adaptation import Identification, MomentumBalance, Prior, sampled
from repro.control.conditions import measured, sensor_errors
from repro.control.state_filter import FilteredIdentification
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.kinds.truth import DampedTruth, Truth


@pytest.fixture(scope="module", params=["sip", "dip"])
def plant(request):
    system = load(request.param)
    return system, Truth(system), training(system)


def identification(system, model, wrong, samples, noise=2e-3, drift=2e-4):
    prior = Prior.of(model, wrong, samples, 0.2, 0.3)
    return Identification(MomentumBalance(model, system, 8, DT), prior, noise, drift)


def test_the_balance_holds_along_a_motion_and_its_slope_is_exact(plant):
    system, model, _ = plant
    balance = MomentumBalance(model, system, 8, DT)
    weights = model.coefficients
    for samples, applied in zip(*motion(system), strict=True):
        error, slope = balance.error(samples, applied, weights)
        assert np.abs(error).max() < 1e-6
        other = balance.error(samples, applied, 1.1 * weights)[0]
        np.testing.assert_allclose(error - 0.1 * slope @ weights, other, atol=1e-12)


def test_wrong_coefficients_are_found_within_a_second(plant):
    system, model, samples = plant
    start = random_start(system, 0.8, 0, 0)
    factors = np.random.default_rng([*start.seed, 1]).uniform(0.8, 1.2, len(model.coefficients))
    adaptive = identification(system, model, model.coefficients * factors, samples)
    for stretch, applied in zip(*motion(system), strict=True):
        adaptive.update(stretch, applied)
    np.testing.assert_allclose(adaptive.weights, model.coefficients, rtol=1e-3)
    assert adaptive.refused == 0


def test_it_is_the_batch_solution_of_prior_and_measurements(plant):
    """The filter gives the least-squares solution for weights, drifts and what was measured wrongly, all together."""
    system, model, samples = plant
    adaptive = identification(system, model, 1.1 * model.coefficients, samples, noise=1e-2, drift=3e-3)
    prior, n_w, n_q, steps = adaptive.prior, len(model.coefficients), system.n_q, 6
    root = np.linalg.cholesky(np.linalg.inv(prior.covariance)).T
    rows, right = [np.hstack([root, np.zeros((n_w, n_q * (steps + 1)))])], [root @ prior.weights]
    wrong = np.diag(1 / (1e-2 * prior.momentum))
    drifted = np.diag(1 / (3e-3 * prior.momentum))
    offsets = n_w + n_q * np.arange(steps + 2)  # of the unexplained momentum at each end of a stretch

    def add(right_hand, parts):
        row = np.zeros((n_q, offsets[-1]))
        for start, part in parts:
            row[:, start : start + part.shape[1]] += part
        rows.append(row)
        right.append(right_hand)

    add(np.zeros(n_q), [(offsets[0], wrong)])
    impulses, slopes = np.zeros(n_q), np.zeros((n_q, n_w))
    for k, (stretch, applied) in enumerate(zip(*motion(system, steps=steps), strict=True)):
        impulse, slope = adaptive.balance.error(stretch, applied, np.zeros(n_w))
        impulses, slopes = impulses + impulse, slopes + slope
        add(np.zeros(n_q), [(offsets[k], -drifted), (offsets[k + 1], drifted)])
        add(wrong @ impulses, [(0, wrong @ slopes), (offsets[k + 1], wrong)])
        adaptive.update(stretch, applied)
    solution, *_ = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)
    np.testing.assert_allclose(adaptive.weights, solution[:n_w], rtol=1e-6)
    np.testing.assert_allclose(adaptive.unexplained, solution[-n_q:], rtol=1e-5, atol=1e-9)


def test_noise_averages_out_over_long_motions():
    """Under noise of 1 mm, 1 mrad, 5 mm/s and 10 mrad/s the forces are right to a fiftieth after two seconds."""
    system = load("dip")
    model, samples = Truth(system), training(system)
    adaptive = identification(system, model, 1.1 * model.coefficients, samples)
    stretches, forced = motion(system, steps=50)
    generator = np.random.default_rng(0)
    seen = measured(np.concatenate([stretches[0, :1], stretches[:, 1:].reshape(-1, 6)]), system, 1.0, generator)
    for k, applied in enumerate(forced):
        adaptive.update(seen[8 * k : 8 * k + 9], applied)
    tau, found = (
        sampled(model, model.inverse_dynamics, samples, weights) for weights in (model.coefficients, adaptive.weights)
    )
    assert np.sqrt(np.mean((found - tau) ** 2) / np.mean(tau**2)) < 0.02


def test_friction_that_the_prior_did_not_have_is_found():
    system = load("dip")
    model = DampedTruth(system)
    plant = load("dip", damping=[0.1, 0.002, 0.003])
    weights = model.initial([np.random.default_rng(0)])[0]
    adaptive = identification(system, model, weights, training(system))
    for stretch, applied in zip(*motion(plant, steps=50), strict=True):
        adaptive.update(stretch, applied)
    np.testing.assert_allclose(adaptive.weights[-3:], [0.1, 0.002, 0.003], rtol=0.02)


def test_a_network_follows_too():
    """A network that knows the nominal plant learns one of other masses; what it sees next it explains better."""
    system, plant = load("sip"), load("sip", m0=0.75, m1=0.17)
    model = Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(2,)))
    samples = training(system)
    trained = fitted(model, samples, evaluate(dynamics_of(system).inverse, *samples))
    adaptive = identification(system, model, trained, samples)
    errors = []
    for stretch, applied in zip(*motion(plant, steps=100), strict=True):
        errors.append(
            [np.abs(adaptive.balance.error(stretch, applied, w)[0]).max() for w in (trained, adaptive.weights)]
        )
        adaptive.update(stretch, applied)
    fixed, followed = np.mean(errors[50:], axis=0)
    assert followed < 0.1 * fixed


def test_the_mass_matrix_stays_positive_definite(plant):
    """Measurements of a plant that cannot be: steps that would spoil M are shortened or not made."""
    system, model, samples = plant
    adaptive = identification(system, model, model.coefficients, samples, noise=1e-5)
    for stretch, applied in zip(*motion(system), strict=True):
        adaptive.update(stretch, -20 * applied)
        assert adaptive._least_eigenvalue(adaptive.weights) >= adaptive._least
    assert adaptive.refused > 0


def test_a_plant_that_changes_is_followed_by_a_filter_that_renews_its_doubt():
    """After two seconds with one plant the masses change: without renewal the old measurements outweigh the new."""
    system, other = load("sip"), load("sip", m0=0.75, m1=0.17)
    model, samples = Truth(system), training(system)
    errors = []
    for renewal in (0.0, 1e-3):
        prior = Prior.of(model, model.coefficients, samples, 0.2, 0.3)
        adaptive = Identification(MomentumBalance(model, system, 8, DT), prior, 2e-3, 2e-4, renewal)
        for plant in (system, other):
            for stretch, applied in zip(*motion(plant, steps=50), strict=True):
                adaptive.update(stretch, applied)
        errors.append(np.abs(adaptive.weights / Truth(other).coefficients - 1).max())
    assert errors[1] < 0.08 < errors[0]


def test_what_is_not_finite_teaches_nothing_and_harms_nothing(plant):
    system, model, samples = plant
    adaptive = identification(system, model, 1.1 * model.coefficients, samples)
    adaptive.update(np.full((9, 2 * system.n_q), np.nan), np.ones((8, 1)))
    np.testing.assert_array_equal(adaptive.weights, 1.1 * model.coefficients)
    for number, (stretch, applied) in enumerate(zip(*motion(system), strict=True)):
        adaptive.update(np.full_like(stretch, np.nan) if number == 3 else stretch, applied)
    np.testing.assert_allclose(adaptive.weights, model.coefficients, rtol=1e-2)


def test_the_prior_is_what_the_training_data_say(plant):
    system, model, samples = plant
    weights = model.coefficients
    prior = Prior.of(model, weights, samples, 0.2, 0.3)
    np.testing.assert_array_equal(prior.weights, weights)
    assert np.linalg.eigvalsh(prior.covariance).min() > 0
    tau = sampled(model, model.inverse_dynamics, samples, weights)
    np.testing.assert_allclose(tau, evaluate(dynamics_of(system).inverse, *samples), atol=1e-10)
    # all weights wrong by 20 % make all forces wrong by 20 %: one deviation of the prior, and 0.2 of each weight's
    assert (0.2 * weights) @ np.linalg.inv(prior.covariance) @ (0.2 * weights) == pytest.approx(
        1.0 + 0.2**2 * len(weights)
    )


def test_friction_is_expected_to_take_a_share_of_the_momentum():
    """Of a joint's friction little more is known than that it takes about 0.3 of the momentum a second."""
    system = load("sip")
    model = DampedTruth(system)
    weights = model.initial([np.random.default_rng(0)])[0]
    samples = training(system)
    loose, tight = (Prior.of(model, weights, samples, 0.2, rate) for rate in (1e6, 1e-3))
    momentum = sampled(model, model.momentum, samples[:2], weights)
    one = np.sqrt(np.mean(momentum**2, axis=0) / np.mean(samples[1] ** 2, axis=0))
    np.testing.assert_allclose(np.sqrt(np.diag(tight.covariance)[-2:]), 1e-3 * one, rtol=0.01)
    assert np.all(np.diag(loose.covariance)[-2:] > np.diag(tight.covariance)[-2:])


def test_simpsons_rule_needs_an_even_number():
    with pytest.raises(ValueError, match="even"):
        MomentumBalance(Truth(load("sip")), load("sip"), 7, DT)


def test_under_noise_the_filter_of_the_state_is_nearer_than_the_balance(plant):
    system, model, samples = plant
    start, draw = random_start(system, 0.8, 0, 0), np.random.default_rng(5)
    wrong = model.coefficients * np.random.default_rng([*start.seed, 1]).uniform(0.8, 1.2, len(model.coefficients))
    by_balance = identification(system, model, wrong, samples)
    by_filter = FilteredIdentification(
        by_balance.balance, by_balance.prior, 2e-3, 2e-4, sensors=sensor_errors(system)
    )  # fmt: skip
    stretches, applied = motion(system, steps=50)
    seen = measured(stretches, system, 1.0, draw)
    seen[1:, 0] = seen[:-1, -1]
    for stretch, force in zip(seen, applied, strict=True):
        by_balance.update(stretch, force)
        by_filter.update(stretch, force)
    off = [np.linalg.norm(each.weights / model.coefficients - 1) for each in (by_filter, by_balance)]
    assert off[0] < 0.5 * off[1]
    assert np.abs(by_filter._state - stretches[-1, -1]).max() < 0.01  # what is measured is off by 0.01 rad/s


def test_the_filter_begins_anew_after_a_motion_without_numbers(plant):
    system, model, samples = plant
    known = identification(system, model, model.coefficients, samples)
    filtered = FilteredIdentification(known.balance, known.prior, 2e-3, 2e-4, sensors=sensor_errors(system))
    stretches, applied = motion(system, steps=2)
    filtered.update(stretches[0], applied[0])
    filtered.update(np.full_like(stretches[0], np.nan), applied[0])
    filtered.update(stretches[1], applied[1])
    np.testing.assert_allclose(filtered.weights, model.coefficients, rtol=1e-3)
