"""The filter that linearises the last motions anew, for models that are not linear in their weights."""

import numpy as np
import pytest
from excited_motion import DT, fitted, motion, training
from scipy.optimize import least_squares

from repro.codegen.array_evaluation import evaluate
from repro.control.adaptation import Identification, MomentumBalance, Prior
from repro.control.iterated_identification import IteratedIdentification
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.kinds.truth import Truth

NOISE, DRIFT = 2e-3, 2e-4


def network_of(seed):
    """A network of the nominal plant, its training data, and a plant of other masses and length."""
    system, plant = load("sip"), load("sip", m0=0.75, m1=0.17, L1=0.55)
    model = Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(), skip=False))
    samples = training(system)
    weights = fitted(model, samples, evaluate(dynamics_of(system).inverse, *samples), seed)
    return model, system, plant, samples, weights


@pytest.fixture(scope="module")
def network():
    return network_of(0)


def followed(kind, network, steps, **options):
    model, system, plant, samples, weights = network
    filtered = kind(
        MomentumBalance(model, system, 8, DT), Prior.of(model, weights, samples, 0.2, 0.3), NOISE, DRIFT, **options
    )
    for stretch, applied in zip(*motion(plant, steps=steps), strict=True):
        filtered.update(stretch, applied)
    return filtered


def test_many_motions_are_explained_as_one_is(network):
    model, system, plant, _, weights = network
    for each, at in ((model, weights), (Truth(system), Truth(system).coefficients)):
        balance = MomentumBalance(each, system, 8, DT)
        stretches, applied = motion(plant, steps=3)
        explained, slopes = balance.explained(stretches, at)
        for k, (stretch, inputs) in enumerate(zip(stretches, applied, strict=True)):
            error, slope = balance.error(stretch, inputs, at)
            np.testing.assert_allclose(balance.impulse(stretch, inputs) - explained[k], error, atol=1e-14)
            np.testing.assert_allclose(slopes[k], slope, atol=1e-13)


def test_a_factor_of_the_mass_matrix_makes_the_balance_nonlinear(network):
    model, system = network[:2]
    assert MomentumBalance(Truth(system), system, 8, DT).is_linear
    assert not MomentumBalance(model, system, 8, DT).is_linear


@pytest.mark.parametrize("lag", [1, 4, 64])
def test_of_a_linear_model_it_is_the_same_filter(lag):
    system = load("dip")
    model, samples = Truth(system), training(system)
    wrong = model.coefficients * np.random.default_rng(1).uniform(0.9, 1.1, len(model.coefficients))
    known = MomentumBalance(model, system, 8, DT), Prior.of(model, wrong, samples, 0.2, 0.3), NOISE, DRIFT, 1e-3
    plain, iterated = Identification(*known), IteratedIdentification(*known, lag=lag)
    for stretch, applied in zip(*motion(system, steps=12), strict=True):
        plain.update(stretch, applied)
        iterated.update(stretch, applied)
        np.testing.assert_allclose(iterated.weights, plain.weights, rtol=1e-6)
        np.testing.assert_allclose(iterated.unexplained, plain.unexplained, rtol=1e-5, atol=1e-9)


def test_it_comes_near_the_most_probable_weights():
    """Of five networks most reach the cost of the minimum for prior and all motions together; all come nearer to it."""
    left = [share_left(network_of(seed)) for seed in range(5)]
    assert np.median(left) < 0.05
    assert min(left) >= 0 and max(left) < 0.8


def share_left(network, steps=50):
    """Of the cost above the minimum, found by another method, that one linearisation per motion leaves."""
    model, _, plant, samples, weights = network
    prior = Prior.of(model, weights, samples, 0.2, 0.3)
    balance = MomentumBalance(model, plant, 8, DT)
    stretches, applied = motion(plant, steps=steps)
    driven = np.stack([balance.impulse(*each) for each in zip(stretches, applied, strict=True)])
    number = np.arange(1, steps + 1)
    covariance = NOISE**2 * (np.eye(steps) + 1) + DRIFT**2 * np.minimum.outer(number, number)
    of_sums, of_prior = (np.linalg.inv(np.linalg.cholesky(each)) for each in (covariance, prior.covariance))

    def residuals(w):
        sums = np.cumsum(driven - balance.explained(stretches, w)[0], axis=0)
        return np.concatenate([of_prior @ (w - weights), (of_sums @ (sums / prior.momentum)).ravel()])

    def cost(w):
        return np.sum(residuals(w) ** 2) / 2

    def slopes(w):
        sums = np.cumsum(balance.explained(stretches, w)[1], axis=0) / prior.momentum[:, None]
        return np.vstack([of_prior, -np.einsum("mn,niw->miw", of_sums, sums).reshape(-1, len(w))])

    least = least_squares(residuals, weights, slopes, method="lm", x_scale=1.0).cost
    iterated, once = (cost(followed(kind, network, steps).weights) for kind in (IteratedIdentification, Identification))
    return (iterated - least) / (once - least)


def test_covariances_stay_symmetric_and_positive(network):
    found = followed(IteratedIdentification, network, 12, renewal=1e-3, lag=4)
    np.testing.assert_allclose(found.covariance, found.covariance.T, atol=1e-12 * np.abs(found.covariance).max())
    assert np.linalg.eigvalsh(found.covariance).min() > 0


def test_the_mass_matrix_stays_positive_definite(network):
    model, system, _, samples, weights = network
    prior = Prior.of(model, weights, samples, 0.2, 0.3)
    filtered = IteratedIdentification(MomentumBalance(model, system, 8, DT), prior, 1e-5, DRIFT)
    for stretch, applied in zip(*motion(system), strict=True):
        filtered.update(stretch, -20 * applied)
        assert filtered._least_eigenvalue(filtered.weights) >= filtered._least
    assert filtered.refused > 0


def test_a_motion_without_numbers_starts_a_new_sum(network):
    found = followed(IteratedIdentification, network, 5)
    before = found.weights
    found.update(np.full((9, 4), np.nan), np.ones((8, 1)))
    np.testing.assert_array_equal(found.weights, before)
    stretches, applied = motion(network[2], steps=25, seed=1)
    unexplained = []
    for stretch, inputs in zip(stretches, applied, strict=True):
        unexplained.append(np.linalg.norm(found.balance.error(stretch, inputs, found.weights)[0]))
        found.update(stretch, inputs)
    assert np.mean(unexplained[-5:]) < 0.2 * np.mean(unexplained[:5])
